//! No file uses another that uses it in turn, directly or through others: each can be read, tested
//! and moved after those that it uses.

mod graph;
mod rust;

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use hullmap_tests::outside::workspace;

use graph::Graph;

#[test]
fn files_import_in_one_direction() {
    let listed = std::process::Command::new("git").arg("ls-files").current_dir(workspace()).output().unwrap();
    let listed = String::from_utf8(listed.stdout).unwrap();
    let sources: BTreeMap<PathBuf, String> = listed.lines().filter_map(|f| {
        Some((PathBuf::from(f), fs::read_to_string(workspace().join(f)).ok()?))
    }).collect();
    let mut graph = Graph::default();
    rust::add_edges(&sources, &mut graph);
    let circles = graph.circles();
    println!("{} edges", graph.edge_count());
    for circle in &circles {
        println!("{}", graph.describe(circle));
    }
    assert!(circles.is_empty(), "{}", circles.len());
}
