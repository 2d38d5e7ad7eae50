//! Bodies do not stumble over the seams of a slab that is cut into parts: their path is the same as
//! over the whole slab.

use hullmap_scenes::slide::{Cut, Slide, Slider, deviation};
use hullmap_scenes::way::Way;

/// Compares each cut with the whole slab: height in millimetres, speed in per cent, number of
/// kicks.
fn no_stumble(slider: Slider, height: f32, speed: f32, kicks: usize) {
    for degrees in [0.0, 20.0] {
        let run = |cut: Cut| Slide { cut, degrees, slider }.run(Way::Dispatcher, 2.0);
        let whole = run(Cut::Whole);
        for cut in Cut::CUTS {
            let found = deviation(&whole, &run(cut));
            let is_smooth = found.height * 1e3 <= height && found.speed * 1e2 <= speed && found.kicks <= kicks;
            assert!(is_smooth, "{} on {}, {degrees}°: {found:?}", slider.name(), cut.name());
        }
    }
}

#[test]
fn a_box_slides() {
    no_stumble(Slider::Box, 0.2, 0.2, 0);
}

#[test]
fn a_turned_box_slides() {
    no_stumble(Slider::TurnedBox, 0.2, 0.2, 0);
}

#[test]
fn a_bevelled_prism_slides() {
    no_stumble(Slider::Bevelled, 0.2, 0.2, 0);
}

#[test]
fn a_chair_of_parts_slides() {
    no_stumble(Slider::Chair, 0.2, 0.2, 0);
}

#[test]
fn a_ball_rolls() {
    no_stumble(Slider::Ball, 0.2, 0.2, 0);
}

/// It has corners, over which it bounces by 2 to 5 mm on the whole slab as well.
#[test]
fn a_sphere_of_2048_vertices_rolls() {
    no_stumble(Slider::Sphere, 5.0, 2.5, 2);
}

/// As above.
#[test]
fn a_cylinder_rolls() {
    no_stumble(Slider::Cylinder, 5.0, 2.5, 2);
}

/// Without the correction, bodies topple: the slab is one that shows it.
#[test]
fn parrys_own_hulls_stumble() {
    let run = |cut: Cut| Slide { cut, degrees: 0.0, slider: Slider::Box }.run(Way::Parry, 2.0);
    let found = deviation(&run(Cut::Whole), &run(Cut::Grid));
    assert!(found.height > 5e-3 && found.speed > 0.1 && found.kicks > 0, "{found:?}");
}
