//! Prints how far bodies that slide and roll over a slab cut into parts deviate from their way over
//! the whole slab: with parry's own hulls, with baked hulls, and with `HullDispatcher`.

use clap::Parser;
use hullmap_scenes::slab::Cut;
use hullmap_scenes::slab_sheet::Form;
use hullmap_scenes::slide::{Moment, Slide, Slider, deviation};
use hullmap_scenes::way::Way;

/// Shift of the start on the whole slab, in metres: how far paths diverge that begin apart by it.
const SHIFT: f32 = 1e-5;

/// Deviations of bodies on a slab cut into parts from their way over the whole slab.
#[derive(Parser)]
struct Arguments {
    /// Seconds of each slide
    #[arg(long, default_value_t = 2.0)]
    seconds: f32,
    /// Slopes of the slab, in degrees
    #[arg(long, num_args = 1.., default_values_t = [0.0, 20.0])]
    slopes: Vec<f32>,
    /// Only these ways: parry, A, B
    #[arg(long, num_args = 1.., default_values = ["parry", "A", "B"])]
    ways: Vec<String>,
    /// Only bodies whose names contain this
    #[arg(long, default_value = "")]
    body: String,
    /// Form of the slab: hulls, mesh, field, or two that meet: "mesh, field"
    #[arg(long, num_args = 1.., default_values = ["hulls"])]
    forms: Vec<String>,
    /// Print each step of this cut beside the same step on the whole slab
    #[arg(long)]
    trace: Option<String>,
}

fn main() {
    let arguments = Arguments::parse();
    println!("millimetres of height, per cent of the speed, kicks\n");
    println!(
        "| slab of | slope | body | way | whole: height, speed | whole, start shifted |{}",
        Cut::CUTS.map(|cut| format!(" {} |", cut.name())).concat()
    );
    println!("|---|---|---|---|---|---|{}", "---|".repeat(Cut::CUTS.len()));
    for form in Form::ALL.into_iter().filter(|form| arguments.forms.iter().any(|name| name == form.name())) {
        for degrees in &arguments.slopes {
            for slider in Slider::ALL.into_iter().filter(|slider| slider.name().contains(&arguments.body)) {
                for way in Way::ALL.into_iter().filter(|way| arguments.ways.iter().any(|name| name == way.name())) {
                    row(&arguments, form, *degrees, slider, way);
                }
            }
        }
    }
}

/// Prints a row: the deviations from the way over the whole slab, which is a hull.
fn row(arguments: &Arguments, form: Form, degrees: f32, slider: Slider, way: Way) {
    let run =
        |form: Form, cut: Cut, shift: f32| Slide { form, cut, degrees, slider, shift }.run(way, arguments.seconds);
    let whole = run(Form::Hulls, Cut::Whole, 0.0);
    let text = |found: &[Moment]| {
        let found = deviation(&whole, found);
        format!(" {:.2}, {:.1} %, {} |", found.height * 1e3, found.speed * 1e2, found.kicks)
    };
    let shifted = text(&run(Form::Hulls, Cut::Whole, SHIFT));
    let cell = |cut: Cut| {
        let found = run(form, cut, 0.0);
        if arguments.trace.as_deref() == Some(cut.name()) {
            for (step, (a, b)) in whole.iter().zip(&found).enumerate() {
                eprintln!("{step} {:.5} {:.4} | {:.5} {:.4}", a.position, a.velocity, b.position, b.velocity);
            }
        }
        text(&found)
    };
    let (low, high) =
        whole.iter().fold((f32::MAX, f32::MIN), |(low, high), m| (low.min(m.position.y), high.max(m.position.y)));
    let end = whole.last().map_or(0.0, |m| m.velocity.length());
    println!(
        "| {} | {degrees}° | {} | {} | {:.2}, {end:.2} |{shifted}{}",
        form.name(),
        slider.name(),
        way.name(),
        (high - low) * 1e3,
        Cut::CUTS.map(cell).concat()
    );
}
