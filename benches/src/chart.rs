//! Line charts as SVG: labelled axes from zero, light grid, one colour a line in order from light to dark, and a legend
//! in which every name stands where its line ends. System fonts only; nothing is loaded.

use std::fmt::Write;

/// Size of the picture, in pixels.
const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 520.0;

/// Room around the plot: left, right, above, below.
const MARGIN: [f64; 4] = [84.0, 150.0, 84.0, 64.0];

/// Least distance of two names in the legend.
const LEGEND_STEP: f64 = 21.0;

/// Most grid lines of an axis, about.
const TICKS: f64 = 6.0;

/// Colours from light to dark: teal through blue to plum, all readable on white.
const RAMP: [[f64; 3]; 4] = [[66.0, 178.0, 150.0], [38.0, 128.0, 176.0], [62.0, 74.0, 158.0], [84.0, 18.0, 92.0]];

/// One line.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Points, x ascending, both coordinates at least 0.
    pub points: Vec<[f64; 2]>,
}

/// A chart.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Above the plot, large.
    pub title: String,
    /// Under the title, small.
    pub subtitle: String,
    /// What x is.
    pub x_label: String,
    /// What y is.
    pub y_label: String,
    /// What the names in the legend are.
    pub legend_title: String,
    /// The lines, in order.
    pub series: Vec<Series>,
}

/// An axis from 0 to `end`, in steps that people count in.
#[derive(Clone, Copy, Debug)]
struct Axis {
    step: f64,
    end: f64,
}

impl Axis {
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
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
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
        let greatest = |c: usize| self.series.iter().flat_map(|s| &s.points).map(|p| p[c]).fold(0.0, f64::max);
        let (x_axis, y_axis) = (Axis::new(greatest(0)), Axis::new(greatest(1)));
        let (plot_right, plot_bottom) = (WIDTH - right, HEIGHT - below);
        let x = |value: f64| left + value / x_axis.end * (plot_right - left);
        let y = |value: f64| plot_bottom - value / y_axis.end * (plot_bottom - above);

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
        for tick in y_axis.ticks() {
            let at = y(tick);
            line(format!(
                "<line x1=\"{left}\" y1=\"{at:.1}\" x2=\"{plot_right}\" y2=\"{at:.1}\" stroke=\"{}\"/>",
                if tick == 0.0 { "#555" } else { "#e4e4e4" }
            ));
            line(format!(
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 10.0,
                at + 4.5,
                y_axis.label(tick)
            ));
        }
        for tick in x_axis.ticks() {
            let at = x(tick);
            line(format!(
                "<line x1=\"{at:.1}\" y1=\"{plot_bottom}\" x2=\"{at:.1}\" y2=\"{}\" stroke=\"#555\"/>",
                plot_bottom + 5.0
            ));
            line(format!(
                "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                plot_bottom + 21.0,
                x_axis.label(tick)
            ));
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
        for (number, ((series, end), place)) in self.series.iter().zip(&ends).zip(&places).enumerate() {
            let colour = colour(number, self.series.len());
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

/// Moves places at least [`LEGEND_STEP`] apart, in their order and between the limits, and as little as that takes.
///
/// Places that would overlap join into a stack around the mean of where they want to be.
fn spread(wanted: &[f64], top: f64, bottom: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    // Among equals the later series, of more vertices, stands above.
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]).then(b.cmp(&a)));
    // Stacks from the top: their first place and their members.
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

fn colour(number: usize, count: usize) -> String {
    let at = if count > 1 { number as f64 / (count - 1) as f64 * (RAMP.len() - 1) as f64 } else { 0.0 };
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
    fn axes_count_as_people_do() {
        let axis = Axis::new(9_400.0);
        assert_eq!((axis.step, axis.end), (2_000.0, 10_000.0));
        assert_eq!(axis.label(10_000.0), "10\u{2009}000");
        let small = Axis::new(0.013);
        assert_eq!(small.label(small.step), "0.0025");
        assert_eq!(Axis::new(0.0).end, 1.0);
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
        let series = |name: &str| Series { name: name.to_owned(), points: vec![[1.0, 2.0], [2.0, 3.0]] };
        let chart = Chart {
            title: "a < b & c".to_owned(),
            subtitle: String::new(),
            x_label: "x".to_owned(),
            y_label: "y".to_owned(),
            legend_title: "n".to_owned(),
            series: vec![series("8"), series("16")],
        };
        let svg = chart.to_svg();
        assert!(svg.contains("a &lt; b &amp; c") && svg.trim_end().ends_with("</svg>"));
        assert_eq!(svg.matches("stroke-linejoin").count(), 2);
    }
}
