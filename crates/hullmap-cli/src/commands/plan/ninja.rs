use std::path::Path;

use hullmap_pipeline::jobs::task::Task;

/// Start of the file. `restat`: `bake` does not touch packs that are fresh.
pub const HEAD: &str = "\
# Written by `bake farm plan --emit ninja`. Run it in the folder where it was planned; plan again after
# meshes were added, removed or got other options.
ninja_required_version = 1.5
bake = bake

rule task
  command = $bake farm task $rsp --jobs 1 --quiet
  description = bake $rsp
  rspfile = $rsp
  rspfile_content = $task
  restat = 1
";

/// The edge of a task. Fails if a path contains a line break, which Ninja cannot read.
pub fn build(task: &Task) -> Result<String, String> {
    let mut task = task.clone();
    let (mut packs, mut sources) = (Vec::new(), Vec::new());
    for mesh in &mut task.meshes {
        packs.push(path(&Path::new(&task.out).join(&mesh.pack).to_string_lossy())?);
        let folder = Path::new(&mesh.source).parent().unwrap_or(Path::new(""));
        for input in &mesh.inputs {
            sources.push(path(&folder.join(&input.path).to_string_lossy())?);
        }
        // A file has changed, so its hash must not be fixed.
        mesh.inputs.clear();
        mesh.key.clear();
    }
    (task.key, task.bytes, task.cost_ms) = (String::new(), 0, 0.0);
    sources.sort_unstable();
    sources.dedup();
    let json = serde_json::to_string(&task).map_err(|error| error.to_string())?;
    let (packs, sources) = (packs.join(" $\n    "), sources.join(" $\n    "));
    let index = task.task;
    let json = json.replace('$', "$$");
    Ok(format!("\nbuild $\n    {packs}: task $\n    {sources}\n  rsp = bake-task-{index}.json\n  task = {json}\n"))
}

fn path(path: &str) -> Result<String, String> {
    if path.contains(['\n', '\r']) {
        return Err(format!("{path}: this path contains a line break, which Ninja cannot read; rename it"));
    }
    Ok(path.replace('$', "$$").replace(' ', "$ ").replace(':', "$:"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn special_characters_are_escaped() {
        assert_eq!(path("a b/$c:d.obj").unwrap(), "a$ b/$$c$:d.obj");
        assert!(path("a\nb").is_err());
    }
}
