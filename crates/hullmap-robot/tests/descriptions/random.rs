//! Random URDF texts: outside of the file names of collisions, no byte changes.

use hullmap_robot::{Change, Description, Geometry, Places};
use proptest::prelude::*;

/// White space between elements and attributes.
fn space() -> impl Strategy<Value = String> {
    prop::sample::select(vec!["", " ", "\n", "\r\n", "\t", "\n\n  ", "<!-- a > b -- -->", "\r\n<!--\n-->\t"])
        .prop_map(str::to_owned)
}

/// Attributes of a mesh in any order and style, the file name among them.
fn attributes() -> impl Strategy<Value = String> {
    let one = |name: &'static str, value: &'static str| {
        (prop::sample::select(vec!["'", "\""]), prop::sample::select(vec!["=", " = ", "\n=\t"]))
            .prop_map(move |(quote, equals)| format!(" {name}{equals}{quote}{value}{quote}"))
    };
    let all = (one("filename", "a&amp;b.stl"), one("scale", "1 -1 1"), one("x", "&lt;filename=no&gt;"));
    all.prop_flat_map(|(a, b, c)| Just(vec![a, b, c]).prop_shuffle()).prop_map(|all| all.concat())
}

fn link(index: usize) -> impl Strategy<Value = String> {
    (attributes(), space(), space(), space(), any::<bool>()).prop_map(move |(attributes, a, b, c, is_closed)| {
        let mesh = if is_closed { format!("<mesh{attributes}/>") } else { format!("<mesh{attributes}>{a}</mesh >") };
        format!("<link name='l{index}'>{a}<visual>{b}</visual>{c}<collision>{b}<geometry>{c}{mesh}{a}</geometry>{b}</collision>{c}</link>")
    })
}

/// Descriptions that are damaged below: each format, every kind of change.
const SAMPLES: [(&str, &str); 3] = [
    ("r.urdf", include_str!("files/small.urdf")),
    ("r.sdf", include_str!("files/small.sdf")),
    ("r.xml", include_str!("files/small.xml")),
];

/// A text with pieces of it cut out, repeated, or moved.
fn damaged() -> impl Strategy<Value = (usize, String)> {
    (
        0..SAMPLES.len(),
        prop::collection::vec((any::<prop::sample::Index>(), any::<prop::sample::Index>(), 0..3_u8), 1..4),
    )
        .prop_map(|(sample, steps)| {
            let mut text = SAMPLES[sample].1.to_owned();
            for (a, b, step) in steps {
                // Cuts at tags keep most texts well-formed.
                let tags: Vec<usize> = text.match_indices(['<', '\'']).map(|(at, _)| at).collect();
                if tags.is_empty() {
                    break;
                }
                let (a, b) = (*a.get(&tags), *b.get(&tags));
                let piece = text[a.min(b)..a.max(b)].to_owned();
                match step {
                    0 => text.replace_range(a.min(b)..a.max(b), ""),
                    1 => text.insert_str(a.max(b), &piece),
                    _ => text.insert_str(a.min(b), &piece),
                }
            }
            (sample, text)
        })
}

/// Replaces or removes every mesh of a description, and makes collisions of all visuals.
fn all_changes(description: &Description) -> Vec<Change> {
    let mut changes = Vec::new();
    let names = || vec!["x_hull.obj".to_owned(), "y.obj".to_owned()];
    for (link, own) in description.links.iter().enumerate() {
        for (collision, shape) in own.collisions.iter().enumerate() {
            match &shape.geometry {
                Geometry::Mesh(_) => changes.push(Change::Replace { link, collision, meshes: names() }),
                _ => changes.push(Change::Remove { link, collision }),
            }
        }
        for visual in 0..own.visuals.len() {
            changes.push(Change::FromVisual { link, visual, meshes: Some(names()) });
        }
    }
    changes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn only_file_names_change(links in (1..5_usize).prop_flat_map(|count| (0..count).map(link).collect::<Vec<_>>()),
                              before in space(), after in space(), mark in any::<bool>()) {
        let folder = tempfile::tempdir().unwrap();
        let body = links.iter().map(|link| format!("{before}{link}{after}")).collect::<String>();
        let text = format!("{}<?xml version=\"1.0\"?>{before}<robot name='r'>{body}</robot>{after}", if mark { "\u{feff}" } else { "" });
        let path = folder.path().join("r.urdf");
        std::fs::write(&path, &text).unwrap();
        let description = Description::read(&path, &Places::default()).unwrap();
        prop_assert_eq!(description.links.len(), links.len());
        for link in &description.links {
            let Geometry::Mesh(mesh) = &link.collisions[0].geometry else { panic!("{text}") };
            prop_assert_eq!(&mesh.written, "a&b.stl");
            prop_assert_eq!(mesh.scale, [1.0, -1.0, 1.0]);
        }
        prop_assert_eq!(&description.changed(&[]).unwrap()[0], text.as_bytes());
        let changes: Vec<Change> = (0..links.len())
            .map(|link| Change::Replace { link, collision: 0, meshes: vec!["h<1>.obj".to_owned()] })
            .collect();
        let changed = description.changed(&changes).unwrap().remove(0);
        prop_assert_eq!(String::from_utf8(changed).unwrap(), text.replace("a&amp;b.stl", "h&lt;1&gt;.obj"));
    }

    #[test]
    fn damaged_descriptions_are_errors_or_stay_readable((sample, text) in damaged()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(SAMPLES[sample].0);
        std::fs::write(&path, &text).unwrap();
        if let Ok(description) = Description::read(&path, &Places::default()) {
            prop_assert_eq!(&description.changed(&[]).unwrap()[0], text.as_bytes());
            let changed = description.changed(&all_changes(&description)).unwrap().remove(0);
            std::fs::write(&path, &changed).unwrap();
            let again = Description::read(&path, &Places::default());
            prop_assert!(again.is_ok(), "{}\n{}\n{:?}", text, String::from_utf8_lossy(&changed), again.err());
        }
    }
}
