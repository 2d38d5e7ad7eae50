//! Line charts as SVG: labelled axes, light grid, one colour per line, and a legend in which every
//! name is placed where its line ends. System fonts only; nothing is loaded.

use std::fmt::Write;

/// Size of the picture, in pixels.
const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 520.0;

/// Room around the plot: left, right, above, below.
const MARGIN: [f64; 4] = [84.0, 150.0, 84.0, 64.0];

/// Minimum distance of two names in the legend, in pixels.
const LEGEND_STEP: f64 = 21.0;

/// Approximate maximum number of grid lines of a linear axis.
const TICKS: f64 = 6.0;

/// Colours from light to dark: teal through blue to plum, all readable on white.
const RAMP: [[f64; 3]; 4] = [[66.0, 178.0, 150.0], [38.0, 128.0, 176.0], [62.0, 74.0, 158.0], [84.0, 18.0, 92.0]];

/// One line.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Points with ascending x. On a linear scale both coordinates are at least 0, on a
    /// logarithmic one they are positive.
    pub points: Vec<[f64; 2]>,
    /// Colour as in CSS; `None` for the next one of the ramp.
    pub colour: Option<String>,
}

/// Scale of both axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// From zero, with round steps.
    Linear,
    /// From the largest power of ten below the values (y), and from the first point to the last
    /// (x).
    Logarithmic,
}

/// A chart.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Above the plot, large.
    pub title: String,
    /// Under the title, small.
    pub subtitle: String,
    /// Label of the x axis.
    pub x_label: String,
    /// Label of the y axis.
    pub y_label: String,
    /// Heading of the legend.
    pub legend_title: String,
    /// Scale of both axes.
    pub scale: Scale,
    /// The lines, in the order of their colours.
    pub series: Vec<Series>,
}

/// Ticks of an axis with their labels, and the position of a value on it, from 0 to 1.
#[derive(Clone, Debug)]
struct Axis {
    start: f64,
    end: f64,
    scale: Scale,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// The axis of `values`; `tens` chooses powers of ten for the ticks of a logarithmic axis,
    /// otherwise the values themselves are the ticks.
    fn new(values: impl Iterator<Item = f64>, scale: Scale, tens: bool) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_unstable_by(f64::total_cmp);
        values.dedup();
        let (least, greatest) = (values.first().copied().unwrap_or(1.0), values.last().copied().unwrap_or(1.0));
        match scale {
            Scale::Linear => {
                let steps = Steps::new(greatest);
                let ticks = steps.ticks().map(|tick| (tick, steps.label(tick))).collect();
                Self { start: 0.0, end: steps.end, scale, ticks }
            }
            Scale::Logarithmic if tens => {
                let (low, high) = (least.log10().floor() as i32, greatest.log10().ceil() as i32);
                let ticks = (low..=high).map(|power| (10_f64.powi(power), power_label(power))).collect();
                Self { start: 10_f64.powi(low), end: 10_f64.powi(high), scale, ticks }
            }
            Scale::Logarithmic => {
                let ticks = values.iter().map(|value| (*value, thousands(&value.to_string()))).collect();
                Self { start: least, end: greatest, scale, ticks }
            }
        }
    }

    fn position(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.start) / (self.end - self.start),
            Scale::Logarithmic => (value / self.start).ln() / (self.end / self.start).ln(),
        }
    }
}

/// 0.1, 1, 10, 1 000.
fn power_label(power: i32) -> String {
    match usize::try_from(power) {
        Ok(zeros) => thousands(&format!("1{}", "0".repeat(zeros))),
        Err(_) => format!("{:.*}", power.unsigned_abs() as usize, 10_f64.powi(power)),
    }
}

/// Round steps from 0 to `end`.
#[derive(Clone, Copy, Debug)]
struct Steps {
    step: f64,
    end: f64,
}

impl Steps {
    fn new(greatest: f64) -> Self {
        let rough = if greatest > 0.0 { greatest / TICKS } else { 1.0 };
        let magnitude = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|s| s * magnitude).into_iter().find(|s| *s >= rough);
        let step = step.unwrap_or(10.0 * magnitude);
        Self { step, end: step * (greatest / step - 1e-9).ceil().max(1.0) }
    }

    fn ticks(self) -> impl Iterator<Item = f64> {
        (0..=(self.end / self.step).round() as usize).map(move |i| i as f64 * self.step)
    }

    /// A tick's label, with a thin space between thousands.
    fn label(self, tick: f64) -> String {
        let decimals = (-self.step.log10().floor()).max(0.0) as usize;
        // A step of 2.5 needs a digit more than its magnitude.
        let decimals = if (self.step * 10_f64.powi(decimals as i32)).fract() > 1e-6 { decimals + 1 } else { decimals };
        let text = format!("{tick:.decimals$}");
        let (whole, fraction) = text.split_at(text.find('.').unwrap_or(text.len()));
        thousands(whole) + fraction
    }
}

/// Puts a thin space between thousands.
pub fn thousands(digits: &str) -> String {
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

impl Chart {
    /// The picture.
    pub fn to_svg(&self) -> String {
        let [left, right, above, below] = MARGIN;
        let values = |c: usize| self.series.iter().flat_map(|s| &s.points).map(move |p| p[c]);
        let (x_axis, y_axis) = (Axis::new(values(0), self.scale, false), Axis::new(values(1), self.scale, true));
        let (plot_right, plot_bottom) = (WIDTH - right, HEIGHT - below);
        let x = |value: f64| left + x_axis.position(value) * (plot_right - left);
        let y = |value: f64| plot_bottom - y_axis.position(value) * (plot_bottom - above);

        let mut svg = String::new();
        let mut line = |text: String| {
            svg.push_str(&text);
            svg.push('\n');
        };
        line(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
             height=\"{HEIGHT}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#333\">"
        ));
        line(format!("<title>{}</title>", escaped(&self.title)));
        line("<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>".to_owned());
        line(format!(
            "<text x=\"{left}\" y=\"34\" font-size=\"19\" font-weight=\"bold\" fill=\"#111\">{}</text>",
            escaped(&self.title)
        ));
        line(format!("<text x=\"{left}\" y=\"57\" fill=\"#666\">{}</text>", escaped(&self.subtitle)));
        for (tick, label) in &y_axis.ticks {
            let at = y(*tick);
            line(format!(
                "<line x1=\"{left}\" y1=\"{at:.1}\" x2=\"{plot_right}\" y2=\"{at:.1}\" stroke=\"{}\"/>",
                if *tick == y_axis.start { "#555" } else { "#e4e4e4" }
            ));
            line(format!("<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>", left - 10.0, at + 4.5, label));
        }
        for (tick, label) in &x_axis.ticks {
            let at = x(*tick);
            line(format!(
                "<line x1=\"{at:.1}\" y1=\"{plot_bottom}\" x2=\"{at:.1}\" y2=\"{}\" stroke=\"#555\"/>",
                plot_bottom + 5.0
            ));
            line(format!("<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>", plot_bottom + 21.0, label));
        }
        line(format!(
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\" fill=\"#111\">{}</text>",
            (left + plot_right) / 2.0,
            HEIGHT - 16.0,
            escaped(&self.x_label)
        ));
        line(format!(
            "<text transform=\"translate(22 {:.1}) rotate(-90)\" text-anchor=\"middle\" fill=\"#111\">{}</text>",
            (above + plot_bottom) / 2.0,
            escaped(&self.y_label)
        ));

        let ends: Vec<f64> = self.series.iter().map(|s| y(s.points.last().map_or(0.0, |p| p[1]))).collect();
        let places = spread(&ends, above + LEGEND_STEP / 2.0, plot_bottom);
        for (index, ((series, end), place)) in self.series.iter().zip(&ends).zip(&places).enumerate() {
            let colour = series.colour.clone().unwrap_or_else(|| ramp(index, self.series.len()));
            let mut path = String::new();
            for (i, point) in series.points.iter().enumerate() {
                // Writing to a string does not fail.
                let _ = write!(path, "{}{:.1} {:.1}", if i == 0 { "M" } else { " L" }, x(point[0]), y(point[1]));
            }
            line(format!(
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" stroke-linejoin=\"round\"/>"
            ));
            for point in &series.points {
                line(format!(
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{colour}\"/>",
                    x(point[0]),
                    y(point[1])
                ));
            }
            let line_end = series.points.last().map_or(plot_right, |p| x(p[0]));
            line(format!(
                "<path d=\"M{:.1} {end:.1} L{:.1} {place:.1} h10\" fill=\"none\" stroke=\"{colour}\" \
                 stroke-opacity=\"0.55\"/>",
                line_end + 5.0,
                plot_right + 30.0
            ));
            line(format!(
                "<text x=\"{}\" y=\"{:.1}\" fill=\"{colour}\" font-weight=\"bold\">{}</text>",
                plot_right + 46.0,
                place + 4.5,
                escaped(&series.name)
            ));
        }
        let top = places.iter().copied().fold(plot_bottom, f64::min);
        line(format!(
            "<text x=\"{}\" y=\"{:.1}\" fill=\"#666\">{}</text>",
            plot_right + 46.0,
            top - LEGEND_STEP + 4.5,
            escaped(&self.legend_title)
        ));
        line("</svg>".to_owned());
        svg
    }
}

/// Moves positions by as little as possible, so that they are at least [`LEGEND_STEP`] from each
/// other, in order and between the limits.
///
/// Positions that would overlap join a stack around the mean of their wanted positions.
fn spread(wanted: &[f64], top: f64, bottom: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    // Of two equal positions, the later series is above.
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]).then(b.cmp(&a)));
    // Stacks from the top: first position and members.
    let mut stacks: Vec<(f64, Vec<usize>)> = Vec::new();
    for i in order {
        let mut members = vec![i];
        loop {
            let lifted = members.iter().enumerate().map(|(at, &i)| wanted[i] - at as f64 * LEGEND_STEP).sum::<f64>();
            let height = (members.len() - 1) as f64 * LEGEND_STEP;
            let first = (lifted / members.len() as f64).min(bottom - height).max(top);
            match stacks.pop_if(|(above, others)| *above + others.len() as f64 * LEGEND_STEP > first) {
                Some((_, mut above)) => {
                    above.append(&mut members);
                    members = above;
                }
                None => {
                    stacks.push((first, members));
                    break;
                }
            }
        }
    }
    let mut places = wanted.to_vec();
    for (first, members) in stacks {
        for (at, i) in members.into_iter().enumerate() {
            places[i] = first + at as f64 * LEGEND_STEP;
        }
    }
    places
}

fn ramp(index: usize, count: usize) -> String {
    let at = if count > 1 { index as f64 / (count - 1) as f64 * (RAMP.len() - 1) as f64 } else { 0.0 };
    let low = (at as usize).min(RAMP.len() - 2);
    let share = at - low as f64;
    let [r, g, b] = std::array::from_fn(|c| (RAMP[low][c] + share * (RAMP[low + 1][c] - RAMP[low][c])).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        let steps = Steps::new(9_400.0);
        assert_eq!((steps.step, steps.end), (2_000.0, 10_000.0));
        assert_eq!(steps.label(10_000.0), "10\u{2009}000");
        let small = Steps::new(0.013);
        assert_eq!(small.label(small.step), "0.0025");
        assert_eq!(Steps::new(0.0).end, 1.0);
    }

    #[test]
    fn logarithmic_axes_span_powers_of_ten() {
        let axis = Axis::new([0.3, 40.0, 2_000.0].into_iter(), Scale::Logarithmic, true);
        let labels: Vec<&str> = axis.ticks.iter().map(|(_, label)| label.as_str()).collect();
        assert_eq!(labels, ["0.1", "1", "10", "100", "1\u{2009}000", "10\u{2009}000"]);
        assert!((axis.position(0.1) - 0.0).abs() < 1e-12 && (axis.position(1.0) - 0.2).abs() < 1e-12);
        let values = Axis::new([32.0, 128.0, 32.0].into_iter(), Scale::Logarithmic, false);
        assert_eq!((values.ticks.len(), values.position(64.0)), (2, 0.5));
    }

    #[test]
    fn names_do_not_overlap() {
        let places = spread(&[400.0, 399.0, 398.0, 100.0, 400.0], 90.0, 400.0);
        let mut sorted = places.clone();
        sorted.sort_by(f64::total_cmp);
        assert!(sorted.windows(2).all(|w| w[1] - w[0] >= LEGEND_STEP - 1e-9), "{places:?}");
        assert!(sorted[0] >= 90.0 && sorted[4] <= 400.0, "{places:?}");
        assert_eq!(places[3], 100.0);
    }

    #[test]
    fn text_is_escaped_and_every_line_drawn() {
        let points = vec![[1.0, 2.0], [2.0, 3.0]];
        let series = |name: &str| Series { name: name.to_owned(), points: points.clone(), colour: None };
        let chart = Chart {
            title: "a < b & c".to_owned(),
            subtitle: String::new(),
            x_label: "x".to_owned(),
            y_label: "y".to_owned(),
            legend_title: "n".to_owned(),
            scale: Scale::Linear,
            series: vec![series("8"), series("16")],
        };
        let svg = chart.to_svg();
        assert!(svg.contains("a &lt; b &amp; c") && svg.trim_end().ends_with("</svg>"));
        assert_eq!(svg.matches("stroke-linejoin").count(), 2);
    }
}
