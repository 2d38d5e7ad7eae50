//! From a name in a description to a file: `package://`, `model://`, `file://`, relative and
//! absolute paths.
//!
//! A description may come from an untrusted author, who chose the names. So files are read only
//! below folders that the caller names: the project, and the folders of packages.

use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, OnceLock};

const MAX_ABOVE: usize = 64;

const MAX_PACKAGE_XML: u64 = 1 << 20;

/// Limits of the search for packages below a folder.
const MAX_BELOW: usize = 5;
const MAX_FOLDERS: usize = 20_000;

/// Folders of a workspace that hold copies of packages, or none.
const SKIPPED_FOLDERS: [&str; 5] = ["build", "install", "log", "node_modules", "target"];

/// Marks of the folder of a project.
const PROJECT_MARKS: [&str; 2] = [".git", ".hg"];

/// The folders in which files are looked for.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// Folders that hold packages or models, or are one: `--package-path`.
    pub packages: Vec<PathBuf>,
    /// Canonical folders below which files may be read, in addition to the folders of packages.
    pub roots: Vec<PathBuf>,
    /// Advice for a missing mesh; `None`: to restore it.
    pub remedy: Option<&'static str>,
    /// The folders below `packages` and `roots` with the mark of a package, once searched.
    pub found: Found,
}

/// Folders with the mark of a package: the scheme of the mark, and the folder.
pub type Found = Arc<OnceLock<Vec<(Scheme, PathBuf)>>>;

/// Why a name leads to no file.
#[derive(Clone, Debug, PartialEq)]
pub enum Unresolved {
    /// The name is on another machine.
    Remote,
    /// The mesh is written in the description.
    Inline(Arc<InlineMesh>),
    /// The cause, and what to do.
    Failed(String),
}

/// A mesh that a description contains.
#[derive(Clone, Debug, PartialEq)]
pub struct InlineMesh {
    /// Its name.
    pub name: String,
    /// Its vertices.
    pub vertices: Vec<[f32; 3]>,
    /// Its triangles, counter-clockwise; if there are none, the mesh is the hull of its vertices.
    pub triangles: Vec<[u32; 3]>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Name<'a> {
    /// As it is written, or without its folders.
    pub name: &'a str,
    pub folder: &'a Path,
    /// The attribute that states this folder, with its value; empty if none does.
    pub stated_by: &'a str,
    /// Advice if it leads to no file; `None`: the advice for a missing mesh.
    pub remedy: Option<&'a str>,
}

impl<'a> Name<'a> {
    pub(crate) fn of_mesh(name: &'a str, folder: &'a Path) -> Self {
        Self { name, folder, stated_by: "", remedy: None }
    }
}

/// A package, by the name that a description uses for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NamedPackage {
    pub scheme: Scheme,
    /// Its name there, which may be the name of its folder or the name in its `package.xml`.
    pub name: String,
    /// Its folder, canonical.
    pub folder: PathBuf,
}

impl NamedPackage {
    /// The package that a name states, if the name leads to `file`.
    pub(crate) fn of(name: &str, file: &Path) -> Option<Self> {
        let (scheme, rest) = Scheme::split(name.trim())?;
        let (package, below) = rest.trim_start_matches('/').split_once('/')?;
        let below = plain(Path::new(&below.replace('\\', "/")));
        let folder = file.ancestors().nth(below.components().count())?;
        let folder = (folder.join(&below) == file).then(|| folder.canonicalize().ok())??;
        Some(Self { scheme, name: package.to_owned(), folder })
    }

    /// Name for a description in the folder `target`, which must be in the same package.
    pub(crate) fn name_of(&self, file: &Path, target: &Path) -> Option<String> {
        let below = file.strip_prefix(&self.folder).ok().filter(|_| target.starts_with(&self.folder))?;
        let below = below.to_str()?.replace('\\', "/");
        Some(format!("{}{}/{below}", self.scheme.prefix(), self.name))
    }

    /// The package that a file lies in, by the marks of the folders above it.
    pub(crate) fn above(scheme: Scheme, file: &Path) -> Option<Self> {
        let file = plain(file);
        let folder = file.ancestors().skip(1).take(MAX_ABOVE).find(|above| above.join(scheme.mark()).is_file())?;
        let named = || folder.file_name().map(|name| name.to_string_lossy().into_owned());
        let name = if scheme == Scheme::Package { stated_name(folder).or_else(named) } else { named() };
        Some(Self { scheme, name: name?, folder: folder.to_owned() })
    }
}

/// The scheme of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// `package://`: a folder with `package.xml`.
    Package,
    /// `model://`: a folder with `model.config`.
    Model,
}

impl Scheme {
    /// How it is written.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Package => "package://",
            Self::Model => "model://",
        }
    }

    fn mark(self) -> &'static str {
        match self {
            Self::Package => "package.xml",
            Self::Model => "model.config",
        }
    }

    /// The scheme of a name, and the rest.
    pub fn split(name: &str) -> Option<(Self, &str)> {
        [Self::Package, Self::Model].into_iter().find_map(|scheme| Some((scheme, name.strip_prefix(scheme.prefix())?)))
    }
}

impl Places {
    /// Places of a description: its project, the nearest folder above it with `.git` or `.hg`; or
    /// the package that it lies in; or its folder.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn beside(description: &Path) -> std::io::Result<Self> {
        let folder = folder_of(description).canonicalize()?;
        let marked = |marks: [&str; 2]| {
            let is_marked = |above: &&Path| marks.iter().any(|mark| above.join(mark).exists());
            folder.ancestors().take(MAX_ABOVE).find(is_marked).map(Path::to_owned)
        };
        let root = marked(PROJECT_MARKS).or_else(|| marked([Scheme::Package, Scheme::Model].map(Scheme::mark)));
        Ok(Self { roots: vec![root.unwrap_or(folder)], ..Self::default() })
    }

    /// The file that the name of a mesh in a description in `folder` leads to.
    ///
    /// # Errors
    /// There is no such file, or it lies outside of the folders that may be read. The error is the
    /// same whether or not a file is there.
    pub fn resolve(&self, name: &str, folder: &Path) -> Result<PathBuf, Unresolved> {
        self.find(Name::of_mesh(name, folder))
    }

    /// The folder, or file, that an included model's name leads to, canonical.
    pub(crate) fn folder_of_model(&self, name: &str, folder: &Path) -> Option<PathBuf> {
        let path = match Scheme::split(name) {
            Some((scheme, rest)) => {
                self.folders_of(scheme, rest.trim_matches('/'), folder, |_| true).into_iter().next()?
            }
            None => folder.join(name),
        };
        path.canonicalize().ok()
    }

    pub(crate) fn find(&self, of: Name) -> Result<PathBuf, Unresolved> {
        let (name, folder) = (of.name.trim(), of.folder);
        if name.is_empty() {
            return Err(Unresolved::Failed("the file name is empty; name a mesh".to_owned()));
        }
        let path = if let Some((scheme, rest)) = Scheme::split(name) {
            self.in_package(scheme, rest, folder)?
        } else if let Some(rest) = name.strip_prefix("file://") {
            // `file://localhost/…` is not in use; `file://$(find …)` is a leftover of xacro.
            folder.join(rest)
        } else if name.contains("://") {
            return Err(Unresolved::Remote);
        } else {
            folder.join(name)
        };
        self.checked(Name { name, ..of }, &with_slashes(path))
    }

    /// The file at a path, if it is regular, and inside of the folders that may be read.
    fn checked(&self, Name { name, stated_by, remedy, .. }: Name, path: &Path) -> Result<PathBuf, Unresolved> {
        let path = plain(path);
        let starts_from_root = Path::new(name).has_root() || name.contains("://");
        let start = if stated_by.is_empty() || starts_from_root { String::new() } else { format!(" from {stated_by}") };
        let outside = || {
            Unresolved::Failed(format!(
                "`{name}`{start} leads out of the project and of all packages; name its folder with --package-path (in Python: packages)"
            ))
        };
        let packages: Vec<PathBuf> = self.packages.iter().filter_map(|package| package.canonicalize().ok()).collect();
        let is_inside = |path: &Path| self.roots.iter().chain(&packages).any(|root| path.starts_with(root));
        match path.canonicalize() {
            Ok(real) if !is_inside(&real) => Err(outside()),
            Ok(real) if real.is_file() => Ok(path),
            Ok(_) => Err(Unresolved::Failed(format!("`{name}` is not a regular file; name a mesh"))),
            Err(_) => {
                // The error reveals a missing file only if its nearest existing folder may be read.
                // The folder of a bare name is the current one.
                let real = |above: &Path| Path::new(".").join(above).canonicalize().ok();
                let above = path.ancestors().skip(1).find_map(real);
                match above {
                    Some(above) if is_inside(&above) => {
                        let remedy = remedy.or(self.remedy).unwrap_or("restore it");
                        Err(Unresolved::Failed(format!("no file `{name}`{start}; {remedy}")))
                    }
                    _ => Err(outside()),
                }
            }
        }
    }

    fn in_package(&self, scheme: Scheme, rest: &str, folder: &Path) -> Result<PathBuf, Unresolved> {
        // `package:///` is as common as `package://`.
        let rest = rest.trim_start_matches('/');
        let (package, below) = rest.split_once('/').unwrap_or((rest, ""));
        let not_found = || {
            Unresolved::Failed(format!(
                "no folder of the {} `{package}`; name it, or the folder that holds it, with --package-path (in Python: packages)",
                if scheme == Scheme::Package { "package" } else { "model" }
            ))
        };
        if package.is_empty() || Path::new(package).components().any(|part| !matches!(part, Component::Normal(_))) {
            return Err(not_found());
        }
        let folders = self.folders_of(scheme, package, folder, |folder| folder.join(below).is_file());
        let file = folders.iter().map(|folder| folder.join(below)).find(|path| path.is_file());
        file.or_else(|| folders.first().map(|folder| folder.join(below))).ok_or_else(not_found)
    }

    /// Folders that may be this package, the most certain first: from `--package-path`, then
    /// folders above the description with the mark, then folders with only the name; if none
    /// `holds` the file, folders with the mark anywhere below.
    fn folders_of(&self, scheme: Scheme, package: &str, folder: &Path, holds: impl Fn(&Path) -> bool) -> Vec<PathBuf> {
        let is_named = |folder: &Path| folder.file_name().is_some_and(|name| name == package);
        let is_package = |folder: &Path| {
            is_named(folder) || scheme == Scheme::Package && stated_name(folder).as_deref() == Some(package)
        };
        let mut found = Vec::new();
        for named in &self.packages {
            if named.canonicalize().is_ok_and(|named| is_package(&named)) {
                found.push(named.clone());
            }
            let inner = std::fs::read_dir(named).into_iter().flatten().flatten().map(|entry| entry.path());
            let mut inner: Vec<PathBuf> = inner.filter(|path| path.is_dir()).collect();
            inner.sort();
            found.extend(inner.iter().filter(|path| is_package(path)).cloned());
            found.extend(inner.iter().map(|path| path.join(package)).filter(|path| path.is_dir()));
        }
        let mut unmarked = Vec::new();
        let canonical = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        for above in canonical.ancestors().take(MAX_ABOVE) {
            let beside = above.join(package);
            for candidate in
                [Some(above.to_owned()).filter(|above| is_package(above)), Some(beside).filter(|path| path.is_dir())]
            {
                let Some(candidate) = candidate else { continue };
                if candidate.join(scheme.mark()).is_file() { found.push(candidate) } else { unmarked.push(candidate) }
            }
        }
        found.extend(unmarked);
        if !found.iter().any(|folder| holds(folder)) {
            let below = self.found.get_or_init(|| self.search());
            let own = below.iter().filter(|(own, folder)| *own == scheme && is_package(folder));
            found.extend(own.map(|(_, folder)| folder.clone()));
        }
        found
    }

    /// Packages and models below the folders that may be read, in the order of their paths.
    fn search(&self) -> Vec<(Scheme, PathBuf)> {
        let mut found = Vec::new();
        let mut waiting: Vec<(PathBuf, usize)> =
            self.roots.iter().chain(&self.packages).rev().map(|folder| (folder.clone(), 0)).collect();
        let mut left = MAX_FOLDERS;
        while let Some((folder, depth)) = waiting.pop() {
            let marks =
                [Scheme::Package, Scheme::Model].into_iter().filter(|scheme| folder.join(scheme.mark()).is_file());
            found.extend(marks.map(|scheme| (scheme, folder.clone())));
            if depth == MAX_BELOW {
                continue;
            }
            let entries = std::fs::read_dir(&folder).into_iter().flatten().flatten();
            // Links may lead anywhere.
            let inner = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
            let is_searched = |name: &str| !name.starts_with('.') && !SKIPPED_FOLDERS.contains(&name);
            let inner = inner.filter(|entry| entry.file_name().to_str().is_some_and(is_searched));
            let mut inner: Vec<PathBuf> = inner.map(|entry| entry.path()).take(left).collect();
            left -= inner.len();
            inner.sort();
            waiting.extend(inner.into_iter().rev().map(|folder| (folder, depth + 1)));
        }
        found
    }
}

pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

fn stated_name(folder: &Path) -> Option<String> {
    let path = folder.join(Scheme::Package.mark());
    let kind = std::fs::metadata(&path).ok()?;
    if !kind.is_file() || kind.len() > MAX_PACKAGE_XML {
        return None;
    }
    let text = std::fs::read_to_string(path).ok()?;
    let document = roxmltree::Document::parse(&text).ok()?;
    let name = document.root_element().children().find(|node| node.has_tag_name("name"))?;
    name.text().map(|text| text.trim().to_owned())
}

/// A path of Windows, as programs write it that run there, if the path itself leads nowhere.
fn with_slashes(path: PathBuf) -> PathBuf {
    match path.to_str() {
        Some(text) if text.contains('\\') && !path.exists() => PathBuf::from(text.replace('\\', "/")),
        _ => path,
    }
}

/// A path without `.` and `..`, without access to the file system. A relative path may keep
/// leading `..`.
pub fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => match plain.components().next_back() {
                Some(Component::Normal(_)) => drop(plain.pop()),
                Some(Component::RootDir | Component::Prefix(_)) => {}
                _ => plain.push(".."),
            },
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}

/// The path from a folder to a file, with `/`; both absolute or both relative to the same folder.
/// `None` if there is none, for instance between drives.
pub fn relative(file: &Path, folder: &Path) -> Option<String> {
    let (file, folder) = (plain(file), plain(folder));
    let file: Vec<Component> = file.components().collect();
    let folder: Vec<Component> = folder.components().collect();
    let shared = file.iter().zip(&folder).take_while(|(a, b)| a == b).count();
    let is_step = |part: &Component| matches!(part, Component::Normal(_));
    if !folder[shared..].iter().all(is_step) || !file[shared..].iter().all(is_step) {
        return None;
    }
    let up = folder[shared..].iter().map(|_| "..");
    let down = file[shared..].iter().map(|part| part.as_os_str().to_str());
    up.map(Some).chain(down).collect::<Option<Vec<&str>>>().map(|steps| steps.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[(&str, &str)]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let root = folder.path().canonicalize().unwrap();
        (folder, root)
    }

    #[test]
    fn names_lead_to_files() {
        let (_guard, root) = folder(&[
            ("ws/arm/package.xml", "<package><name>arm</name></package>"),
            ("ws/arm/meshes/a.stl", ""),
            ("ws/arm/urdf/b.stl", ""),
            ("ws/checkout/package.xml", "<package>\n<name> other </name></package>"),
            ("ws/checkout/c.stl", ""),
            ("ws/plain/d.stl", ""),
            ("ws/src/repo/desc/package.xml", "<package><name>deep</name></package>"),
            ("ws/src/repo/desc/f.stl", ""),
            ("ws/install/deep/package.xml", ""),
            ("ws/install/deep/f.stl", ""),
            ("else/far/e.stl", ""),
            ("else/far/model.config", ""),
        ]);
        let places = Places {
            packages: vec![root.join("else"), root.join("ws/checkout")],
            roots: vec![root.join("ws")],
            ..Places::default()
        };
        let urdf = root.join("ws/arm/urdf");
        for (name, file) in [
            ("package://arm/meshes/a.stl", "ws/arm/meshes/a.stl"),
            ("package://plain/d.stl", "ws/plain/d.stl"),
            ("package:///plain/d.stl", "ws/plain/d.stl"),
            ("package://other/c.stl", "ws/checkout/c.stl"),
            ("package://far/e.stl", "else/far/e.stl"),
            ("package://deep/f.stl", "ws/src/repo/desc/f.stl"),
            ("model://far/e.stl", "else/far/e.stl"),
            ("b.stl", "ws/arm/urdf/b.stl"),
            ("../meshes/a.stl", "ws/arm/meshes/a.stl"),
            ("..\\meshes\\a.stl", "ws/arm/meshes/a.stl"),
            (&format!("file://{}/ws/plain/d.stl", root.display()), "ws/plain/d.stl"),
            (&format!("{}/ws/plain/d.stl", root.display()), "ws/plain/d.stl"),
        ] {
            assert_eq!(places.resolve(name, &urdf), Ok(root.join(file)), "{name}");
        }
        for (name, expected) in [
            ("package://gone/a.stl", "no folder of the package `gone`"),
            ("package://../a.stl", "no folder of the package `..`"),
            ("gone.stl", "no file `gone.stl`; restore it"),
            ("../../../../../../../../etc/passwd", "leads out of the project"),
            ("/etc/no-such-file", "leads out of the project"),
            ("../meshes", "is not a regular file"),
            ("", "the file name is empty"),
        ] {
            match places.resolve(name, &urdf) {
                Err(Unresolved::Failed(message)) => assert!(message.contains(expected), "{name}: {message}"),
                other => panic!("{name}: {other:?}"),
            }
        }
        assert_eq!(places.resolve("https://x/y.stl", &urdf), Err(Unresolved::Remote));
        let named = |scheme, file: &str| NamedPackage::above(scheme, &root.join(file)).map(|own| own.name);
        assert_eq!(named(Scheme::Package, "ws/checkout/x/y.obj").as_deref(), Some("other"));
        assert_eq!(named(Scheme::Model, "else/far/x.obj").as_deref(), Some("far"));
        assert_eq!(named(Scheme::Model, "ws/arm/x.obj"), None);
        for name in ["checkout", "other"] {
            let package =
                NamedPackage::of(&format!("package:///{name}/./c.stl"), &root.join("ws/checkout/c.stl")).unwrap();
            let found = package.name_of(&root.join("ws/checkout/h/x.obj"), &root.join("ws/checkout/urdf"));
            assert_eq!(found, Some(format!("package://{name}/h/x.obj")));
            assert_eq!(package.name_of(&root.join("ws/checkout/h/x.obj"), &root.join("ws/arm")), None);
        }
        let outside = Name { stated_by: "meshdir=\"../..\"", ..Name::of_mesh("x.stl", Path::new("/")) };
        match places.find(outside) {
            Err(Unresolved::Failed(message)) => {
                assert!(message.starts_with("`x.stl` from meshdir=\"../..\" leads out"), "{message}")
            }
            other => panic!("{other:?}"),
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_do_not_lead_out() {
        let (_guard, root) = folder(&[("in/a.urdf", ""), ("out/x.stl", "")]);
        std::os::unix::fs::symlink(root.join("out/x.stl"), root.join("in/x.stl")).unwrap();
        let places = Places { roots: vec![root.join("in")], ..Places::default() };
        assert!(matches!(places.resolve("x.stl", &root.join("in")), Err(Unresolved::Failed(_))));
    }

    #[test]
    fn relative_paths_climb() {
        assert_eq!(relative(Path::new("/a/b/x.obj"), Path::new("/a/c/d")).as_deref(), Some("../../b/x.obj"));
        assert_eq!(relative(Path::new("b/x.obj"), Path::new("b/./")).as_deref(), Some("x.obj"));
        assert_eq!(relative(Path::new("/x.obj"), Path::new("a")), None);
        assert_eq!(plain(Path::new("../a/../../b")), Path::new("../../b"));
    }
}
