//! The pages of `bake report`: their contents, and how a browser renders them.
//!
//! Pages measure themselves: after drawing, they read their pixels back and store the drawn
//! fraction in attributes. A headless Chromium loads them, and prints the document and all console
//! messages. If Chromium is not installed (Debian: `apt install chromium`), those tests print
//! "skipped".

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    sync::OnceLock,
};

use hullmap_testkit::{
    command::{Run, bake_in},
    files::{folder, workspace, write},
};
use shapes::families::Family;
use tempfile::TempDir;

/// Names under which Chromium is installed.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome-stable", "google-chrome"];

/// Time limit of a page, in its own milliseconds. It draws at once, and waits only for images.
const PAGE_TIME: &str = "--virtual-time-budget=4000";

/// Number of times that a page is loaded until its script ends.
const ATTEMPTS: usize = 3;

/// A name that tries to break out of every context in which it may appear.
const HOSTILE: &str =
    "</script><script>document.documentElement.dataset.owned=1</script><img src=x onerror=alert(1)> \"'& ☃ é";

/// A page as rendered by the browser.
struct Loaded {
    /// The document after its scripts have run.
    dom: String,
    /// Console messages, except those in which the driver says that reading pixels back is slow:
    /// that is how the test looks at the page.
    console: Vec<String>,
}

impl Loaded {
    /// Value of an attribute in the tag that holds `mark`.
    #[track_caller]
    fn attribute(&self, mark: &str, name: &str) -> &str {
        let tag = self.dom.split('<').find(|tag| tag.contains(mark)).unwrap_or_else(|| panic!("no {mark}"));
        let value = tag.split(&format!(" {name}=\"")).nth(1).unwrap_or_else(|| panic!("no {name} in <{tag}"));
        value.split('"').next().unwrap()
    }

    #[track_caller]
    fn share(&self, id: &str) -> f64 {
        self.attribute(&format!("id=\"{id}\""), "data-drawn").parse().unwrap()
    }

    /// Panics if the page did not finish, or if any error occurred.
    #[track_caller]
    fn assert_sound(&self) {
        assert!(self.console.is_empty(), "{:?}", self.console);
        assert_eq!(self.attribute("html ", "data-ready"), "true");
        assert!(!self.dom.contains("data-errors") && !self.dom.contains("data-owned"));
    }
}

/// The browser. If there is no browser, prints that the rest of the test is skipped.
fn browser() -> Option<&'static str> {
    static FOUND: OnceLock<Option<&str>> = OnceLock::new();
    let answers = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|out| out.status.success());
    let found = *FOUND.get_or_init(|| BROWSERS.into_iter().find(answers));
    if found.is_none() {
        println!("skipped: {:?}: no Chromium is installed", std::thread::current().name());
    }
    found
}

/// Loads a page, again if its script did not end: on a busy machine, the browser's own time may run
/// out before.
fn load(browser: &str, page: &Path, more: &[&str]) -> Loaded {
    let mut loads = (0..ATTEMPTS).map(|_| load_once(browser, page, more));
    loads.find(|loaded| loaded.dom.contains("data-ready")).expect("the script of the page ends")
}

/// Loads a page, with WebGL in software.
fn load_once(browser: &str, page: &Path, more: &[&str]) -> Loaded {
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run", "--window-size=1280,1600"])
        .args(["--use-gl=angle", "--use-angle=swiftshader", concat!("--enable-un", "safe-swiftshader")])
        .args(["--enable-logging=stderr", PAGE_TIME, "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(more)
        .arg(address(page))
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let said = |line: &&str| line.contains("CONSOLE") && !line.contains("GL Driver Message (OpenGL, Performance");
    let console = stderr.lines().filter(said).map(str::to_owned).collect();
    Loaded { dom: String::from_utf8(output.stdout).unwrap(), console }
}

fn address(page: &Path) -> String {
    let path = page.canonicalize().unwrap();
    let escaped = path.to_str().unwrap().bytes().map(|byte| match byte {
        b'/' | b'.' | b'_' | b'-' => char::from(byte).to_string(),
        _ if byte.is_ascii_alphanumeric() => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    });
    format!("file://{}", escaped.collect::<String>())
}

fn run(folder: &TempDir, words: &[&str]) -> Run {
    bake_in(folder.path(), words)
}

/// The page with its details opened, in a browser.
fn load_open(browser: &str, page: &Path, more: &[&str]) -> Loaded {
    let open = page.with_file_name("open.html");
    fs::write(&open, text(page).replace(" id=\"more\"", " id=\"more\" open")).unwrap();
    load(browser, &open, more)
}

/// A folder with packs of these assets.
fn baked(assets: &[&str], more: &[&str]) -> TempDir {
    let folder = folder(&[]);
    for name in assets.iter().map(|asset| format!("{asset}.obj")) {
        write(&folder, &format!("in/{name}"), fs::read(workspace().join("assets").join(&name)).unwrap());
    }
    run(&folder, &[&["build", "in", "--out", "packs"], more].concat()).expect(0);
    folder
}

fn page(folder: &TempDir, pack: &str) -> PathBuf {
    let run = run(folder, &["report", &format!("packs/{pack}.hullmap"), "--out", "page.html"]).expect(0);
    assert!(run.stdout.starts_with("page.html: "), "{run:?}");
    folder.path().join("page.html")
}

fn text(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).unwrap()
}

/// Points as OBJ text.
fn cloud(points: impl IntoIterator<Item = [f32; 3]>) -> String {
    points.into_iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect()
}

#[test]
fn a_page_draws_mesh_hull_and_map() {
    let assets = ["rock", "gear", "flat_sheet", "segment", "single_point", "point_cloud"];
    let folder = baked(&assets, &[]);
    let Some(browser) = browser() else { return };
    for asset in assets {
        let loaded = load_open(browser, &page(&folder, asset), &[]);
        loaded.assert_sound();
        assert_eq!(loaded.attribute("html ", "data-webgl"), "true");
        // A dot is a dot, a line a line; all else fills a fair part of its canvas, never all.
        let least = match asset {
            "single_point" => 1e-4,
            "segment" => 5e-4,
            "point_cloud" => 0.01,
            _ => 0.05,
        };
        for id in ["source", "hull"] {
            let share = loaded.share(id);
            assert!(share > least && share < 0.9, "{asset}: {id} {share}");
        }
        // The cross is half of its box of four by three; a point has one colour, and lines and
        // letters a few.
        let colours: usize = loaded.attribute("id=\"gauss\"", "data-colours").parse().unwrap();
        let least = match asset {
            "rock" => 500,
            "gear" | "point_cloud" => 80,
            _ => 2,
        };
        assert!((0.4..0.6).contains(&loaded.share("gauss")) && colours >= least, "{asset}: {colours}");
        assert_eq!(loaded.dom.matches("class=\"chart\"").count(), 2);
        assert!(loaded.dom.contains("<figcaption id=\"hull-caption\">The convex hull: "));
    }
}

#[test]
fn a_pack_of_many_hulls_has_a_choice() {
    let folder = baked(&["two_objects"], &["--split", "object"]);
    let page = page(&folder, "two_objects");
    let Some(browser) = browser() else { return };
    let loaded = load(browser, &page, &[]);
    loaded.assert_sound();
    assert_eq!(loaded.attribute("html ", "data-hull"), "all");
    let together = loaded.share("hull");
    assert!(together > 0.02);
    assert_eq!(loaded.dom.matches("<option value=\"").count() - 3, 3, "all, and each");

    // Choosing one shows it alone, larger, on both sides.
    let act = "const choice = document.getElementById('hull-choice'); choice.value = '1'; choice.dispatchEvent(new Event('change'));";
    let loaded = acted(browser, &page, act);
    loaded.assert_sound();
    assert_eq!(loaded.attribute("html ", "data-hull"), "1");
    assert!(loaded.share("hull") > 2.0 * together && loaded.share("source") > 2.0 * together);
    assert!(loaded.dom.contains("#1 right_octahedron: 6 vertices, 8 faces"));
}

/// The page after some more script has run at its end.
fn acted(browser: &str, page: &Path, script: &str) -> Loaded {
    let acting = page.with_file_name("acting.html");
    fs::write(&acting, text(page).replace("</body>", &format!("<script>{{ {script} }}</script></body>"))).unwrap();
    load(browser, &acting, &[])
}

#[test]
fn keys_turn_the_hull_and_walk_over_the_map() {
    let folder = baked(&["pawn"], &[]);
    let page = page(&folder, "pawn");
    let Some(browser) = browser() else { return };
    let act = "const press = (id, key) => document.getElementById(id).dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
        const pixels = (id) => document.getElementById(id).toDataURL();
        document.getElementById('more').open = true;
        const before = ['source', 'hull'].map(pixels);
        press('gauss', 'ArrowRight'); press('hull', 'ArrowLeft'); press('source', '+');
        requestAnimationFrame(() => requestAnimationFrame(() => {
          document.documentElement.dataset.moved = ['source', 'hull'].filter((id, at) => pixels(id) !== before[at]).length;
        }));";
    let loaded = acted(browser, &page, act);
    loaded.assert_sound();
    assert_eq!(loaded.attribute("html ", "data-moved"), "2", "both turn together");
    let readout = loaded.dom.split("id=\"readout\"").nth(1).unwrap().split("</p>").next().unwrap();
    for part in ["direction (", "vertex ", "leaf at block ", "candidate", "depth ", " lanes: "] {
        assert!(readout.contains(part), "{part}: {readout}");
    }
    // The middle of +y; the pawn is turned on a lathe, with a corner of its base there or just
    // beside.
    assert!(readout.contains(", 0.9999, "), "{readout}");
}

#[test]
fn without_webgl_there_is_a_message_and_a_still_picture() {
    let folder = baked(&["gear"], &[]);
    let page = page(&folder, "gear");
    let Some(browser) = browser() else { return };
    let loaded = load_open(browser, &page, &["--disable-3d-apis"]);
    loaded.assert_sound();
    assert_eq!(loaded.attribute("html ", "data-webgl"), "false");
    assert!(loaded.attribute("html ", "class").contains("no-webgl"));
    assert!(loaded.share("gauss") > 0.4, "the map needs no WebGL");
    assert!(text(&page).contains("This browser shows no WebGL"));
}

#[test]
fn a_folder_has_an_index_and_a_page_a_pack() {
    let folder = baked(&["rock", "flat_sheet", "gear", "cube"], &[]);
    fs::create_dir_all(folder.path().join("packs/deep/er")).unwrap();
    fs::rename(folder.path().join("packs/cube.hullmap"), folder.path().join("packs/deep/er/a b#1.hullmap")).unwrap();
    let run = run(&folder, &["report", "packs", "--out", "site/report.html"]).expect(0);
    assert!(run.stdout.starts_with("site/report.html: 4 packs"), "{run:?}");
    let index = text(folder.path().join("site/report.html"));
    let links: Vec<String> = links(&index);
    assert_eq!(links.len(), 8, "a picture and a name each");
    for link in &links {
        assert!(!link.contains("//") && !link.starts_with('/'), "{link}");
        let page = folder.path().join("site").join(decoded(link));
        let back = self::links(&text(&page))[0].clone();
        let back = page.parent().unwrap().join(back).canonicalize().unwrap();
        assert_eq!(back, folder.path().join("site/report.html").canonicalize().unwrap());
    }
    assert!(links.contains(&"report.pages/deep/er/a%20b%231.hullmap.html".to_owned()), "{links:?}");
    // The pack that was moved has lost its source.
    assert!(index.contains("chip odd\">mesh not found: 1<") && index.contains("hull flat_sheet is flat: its "));

    let Some(browser) = browser() else { return };
    let loaded = load(browser, &folder.path().join("site/report.html"), &[]);
    loaded.assert_sound();
    assert_eq!(loaded.attribute("html ", "data-pictures"), "4");
    load(browser, &folder.path().join("site").join(decoded(&links[0])), &[]).assert_sound();
}

fn links(page: &str) -> Vec<String> {
    let hrefs = page.split(" href=\"").skip(1).map(|rest| rest.split('"').next().unwrap().to_owned());
    hrefs.filter(|href| !href.starts_with("data:")).collect()
}

fn decoded(link: &str) -> String {
    let mut parts = link.split('%');
    let mut bytes = parts.next().unwrap().as_bytes().to_vec();
    for part in parts {
        bytes.push(u8::from_str_radix(&part[..2], 16).unwrap());
        bytes.extend(&part.as_bytes()[2..]);
    }
    String::from_utf8(bytes).unwrap()
}

/// A comb of two teeth. A part fills the slot in the end of one of them.
fn comb() -> String {
    let teeth = [(4.2, 3.0), (3.2, 3.0), (3.2, 2.5), (3.0, 2.5), (3.0, 3.0), (2.0, 3.0), (2.0, 1.0), (1.0, 1.0)];
    prism(&[&[(0.0, 0.0), (4.2, 0.0)], &teeth[..], &[(1.0, 3.0), (0.0, 3.0)]].concat())
}

/// The packs of a comb, of this accuracy.
fn baked_comb(max_error: &str) -> TempDir {
    let folder = folder(&[("u.obj", &comb())]);
    run(&folder, &["build", "u.obj", "--out", "packs", "--decompose", "--max-error", max_error]).expect(0);
    folder
}

/// A prism from z = 0 to 1, with a point that nothing references, and one that equals another.
fn prism(outline: &[(f64, f64)]) -> String {
    let count = outline.len();
    let corners: String =
        [0, 1].iter().flat_map(|z| outline.iter().map(move |(x, y)| format!("v {x} {y} {z}\n"))).collect();
    let side = |i: usize| {
        let next = i % count + 1;
        format!("f {i} {next} {} {}\n", next + count, i + count)
    };
    let sides: String = (1..=count).map(side).collect();
    let face = |corners: Vec<usize>| corners.iter().map(|i| format!(" {i}")).collect::<String>();
    let (bottom, top) = (face((1..=count).rev().collect()), face((count + 1..=2 * count).collect()));
    format!("{corners}v 9 9 9\nv 0 0 0\n{sides}f{bottom}\nf{top}\nf 1 {} 2\n", 2 * count + 2)
}

/// The table of hulls was cut off at 1,400 px, and its last columns had to be scrolled into view.
#[test]
fn tables_fit_a_screen_of_1400_px() {
    let name = "a_long_name_without_spaces_of_a_mesh_that_somebody_exported";
    let points = Family::Rock.points(2_000, 5);
    let rock = |scale: f32| cloud(points.iter().map(|p| p.map(|x| x * scale)));
    let files = [(&*format!("in/{name}.obj"), comb()), ("in/small.obj", rock(1e-7)), ("in/large.obj", rock(1e7))];
    let folder = folder(&files.each_ref().map(|(name, text)| (*name, text.as_str())));
    run(&folder, &["build", "in", "--out", "packs", "--decompose", "--max-error", "30%", "--set", "index=cubemap"])
        .expect(0);
    let Some(browser) = browser() else { return };
    let measure = "<script>{ const wide = [...document.querySelectorAll(\".scroll\")].filter((box) => \
                   box.scrollWidth > box.clientWidth + 1).map((box) => box.getAttribute(\"aria-label\").slice(0, 40)); \
                   document.documentElement.dataset.wide = `${document.querySelectorAll(\".scroll\").length} tables, \
                   cut off: ${wide.join(\", \")}`; }</script></body>";
    for pack in [name, "small", "large"] {
        let page = text(page(&folder, pack)).replace("</body>", measure).replace(" id=\"more\"", " id=\"more\" open");
        fs::write(folder.path().join("measured.html"), page).unwrap();
        let loaded = load(browser, &folder.path().join("measured.html"), &["--window-size=1400,1600"]);
        loaded.assert_sound();
        let wide = loaded.attribute("html ", "data-wide").split_whitespace().collect::<Vec<_>>().join(" ");
        let tables = if text(folder.path().join("measured.html")).contains("id=\"parts\"") { 4 } else { 3 };
        assert_eq!(wide, format!("{tables} tables, cut off:"), "{pack}");
    }
}

/// The page marks the greatest protrusion. The slider pulls the parts apart, and buttons show one.
/// `tests/cases/report.md` has the contents of the page.
#[test]
fn buttons_show_parts_and_the_worst_place() {
    let folder = baked_comb("5%");
    let page = page(&folder, "u");
    let html = text(&page);
    let worst = html.split("<tr data-part=\"").nth(1).unwrap().split('"').next().unwrap();
    let Some(browser) = browser() else { return };
    let state = |loaded: &Loaded| ["data-spread", "data-spot"].map(|name| loaded.attribute("html ", name).to_owned());
    assert_eq!(state(&load(browser, &page, &[])), ["0", worst]);
    let act = "const act = (id, change, kind) => { change(document.getElementById(id)); \
               document.getElementById(id).dispatchEvent(new Event(kind)); }; \
               act('spread', (slider) => { slider.value = 1; }, 'input'); \
               act('show-protrusion', (box) => { box.checked = false; }, 'input'); \
               document.querySelectorAll('tr[data-part] button')[1].click();";
    let loaded = acted(browser, &page, act);
    loaded.assert_sound();
    assert_eq!(state(&loaded), ["1", "none"]);
    let second = loaded.attribute("html ", "data-part").to_owned();
    let pressed = "<td class=\"word name\"><button type=\"button\" aria-pressed=\"true\"";
    assert!(loaded.dom.contains(&format!("<tr data-part=\"{second}\">{pressed}")));
    let show = "document.getElementById('show-worst').click();";
    for (act, part, is_pressed) in
        [(show, worst, "true"), (&format!("{show} document.getElementById('reset').click();"), "none", "false")]
    {
        let loaded = acted(browser, &page, act);
        loaded.assert_sound();
        assert_eq!(loaded.attribute("html ", "data-part"), part);
        assert_eq!(loaded.attribute("id=\"show-worst\"", "aria-pressed"), is_pressed);
    }
}

/// `tests/cases/report.md` has the axes of all formats.
#[test]
fn a_button_turns_the_mesh() {
    let folder = folder(&[("u.obj", &comb())]);
    run(&folder, &["build", "u.obj", "--out", "packs", "--quiet"]).expect(0);
    let page = page(&folder, "u");
    let Some(browser) = browser() else { return };
    let state = |loaded: &Loaded| loaded.attribute("html ", "data-up").to_owned();
    assert_eq!(state(&load(browser, &page, &[])), "y");
    let loaded = acted(browser, &page, "document.getElementById('turn').click();");
    loaded.assert_sound();
    assert!(state(&loaded) == "z" && loaded.dom.contains(">Turn (z is up)</button>"));
}

/// At the angle of other meshes, the ground took a seventh of the picture.
#[test]
fn a_level_is_seen_from_above() {
    let corner = |x: i32, y: i32| format!("vertex {x} {y} 0\n");
    let facet = |[a, b, c]: [String; 3]| format!("facet normal 0 0 1\nouter loop\n{a}{b}{c}endloop\nendfacet\n");
    let facets = [[(0, 0), (9, 0), (9, 9)], [(0, 0), (9, 9), (0, 9)]].map(|t| facet(t.map(|(x, y)| corner(x, y))));
    let folder = folder(&[("ground.stl", &format!("solid ground\n{}endsolid ground\n", facets.concat()))]);
    run(&folder, &["build", "ground.stl", "--out", "packs", "--keep-triangles"]).expect(0);
    run(&folder, &["report", "packs/ground.hullmesh", "--out", "page.html"]).expect(0);
    let page = folder.path().join("page.html");
    assert!(text(&page).contains("A level of 2 triangles, kept as they are. It measures 9 × 9 × 0 units."));
    let Some(browser) = browser() else { return };
    let loaded = load(browser, &page, &[]);
    loaded.assert_sound();
    assert!(loaded.share("mesh") > 0.1, "{}", loaded.share("mesh"));
}

/// Pages were wider than a phone.
#[test]
fn pages_fit_a_phone_of_390_px() {
    let name = "in/a_long_name_without_spaces_of_a_mesh_that_somebody_exported_from_a_program.obj";
    let folder = folder(&[(name, &comb())]);
    run(&folder, &["build", "in", "--out", "packs", "--decompose", "--max-error", "5%"]).expect(0);
    run(&folder, &["build", "in", "--out", "packs", "--keep-triangles"]).expect(0);
    run(&folder, &["report", "packs", "--out", "all.html"]).expect(0);
    let Some(browser) = browser() else { return };
    let index = text(folder.path().join("all.html"));
    let mut pages: Vec<String> = links(&index).iter().map(|link| decoded(link)).collect();
    pages.dedup();
    assert_eq!(pages.len(), 2);
    for page in pages.iter().map(String::as_str).chain(["all.html"]) {
        let open = text(folder.path().join(page)).replace("<details", "<details open");
        fs::write(folder.path().join("open.html"), open).unwrap();
        // Windows of Chromium are at least 500 px wide.
        let frame = "<html data-ready=\"true\"><iframe id=\"phone\" src=\"open.html\" style=\"width:390px;height:844px;border:0\">\
                     </iframe><script>phone.onload = () => { document.documentElement.dataset.width = \
                     phone.contentDocument.documentElement.scrollWidth; }</script></html>";
        fs::write(folder.path().join("frame.html"), frame).unwrap();
        let loaded = load(browser, &folder.path().join("frame.html"), &["--allow-file-access-from-files"]);
        let width: u32 = loaded.attribute("html ", "data-width").parse().unwrap();
        assert!(width > 300 && width <= 390, "{page}: {width}");
    }
}

#[test]
fn hostile_names_stay_text() {
    let file = "a<b onclick='x'>&amp;\"{{data}} ☃.obj";
    let solid = |at: i32| format!("v {at} 0 0\nv {at} 1 0\nv {at} 0 1\nv {} 0 0\n", at + 1);
    let faces =
        |first: i32| format!("f {} {} {}\nf {} {} {}\n", first, first + 1, first + 2, first, first + 1, first + 3);
    let source = format!("o {HOSTILE}\n{}{}o \u{202e}{{{{style}}}}\u{1}\n{}{}", solid(0), faces(1), solid(5), faces(5));
    let folder = folder(&[(&format!("in/{file}"), &source)]);
    run(&folder, &["build", "in", "--out", "packs", "--split", "object"]).expect(0);
    run(&folder, &["report", "packs", "--out", "report.html"]).expect(0);
    let index = text(folder.path().join("report.html"));
    let page = folder.path().join(decoded(&links(&index)[0]));
    for text in [&index, &text(&page)] {
        assert!(!text.contains("<b ") && !text.contains("<img src=x") && !text.contains('\u{202e}'), "{text}");
        assert_eq!(text.matches("</script>").count(), text.matches("<script").count());
    }
    assert!(text(&page).contains("&lt;/script&gt;&lt;script&gt;document"));
    let Some(browser) = browser() else { return };
    for page in [&page, &folder.path().join("report.html")] {
        load(browser, page, &[]).assert_sound();
    }
    let loaded = load(browser, &page, &[]);
    assert!(
        loaded.dom.contains("&lt;img src=x onerror=alert(1)&gt; \"'&amp; ☃ é</option>"),
        "the choice names the hull"
    );
}

#[test]
fn large_meshes_and_many_hulls_stay_small() {
    let object = |object: u64| {
        let [right, up] = [object % 20, object / 20].map(|step| step as f32 * 2.0);
        let points = Family::Ball.points(40, object).into_iter().map(|[x, y, z]| [x + right, y + up, z]);
        format!("o part {object}\n{}f -1 -2 -3\n", cloud(points))
    };
    let many: String = (0..400).map(object).collect();
    let folder = folder(&[("in/sphere.obj", &cloud(Family::Sphere.points(40_000, 1))), ("in/many.obj", &many)]);
    run(&folder, &["build", "in", "--out", "packs", "--split", "object", "--set", "vertices=all"]).expect(0);
    let browser = browser();
    for (pack, said) in [("sphere", "triangles"), ("many", "")] {
        let page = page(&folder, pack);
        let bytes = fs::metadata(&page).unwrap().len();
        println!("{pack}: {bytes} bytes");
        assert!(bytes < 6_000_000, "{pack}: {bytes}");
        assert_eq!(text(&page).contains("What is left out"), !said.is_empty(), "{pack}");
        if let Some(browser) = browser {
            let loaded = load_open(browser, &page, &[]);
            loaded.assert_sound();
            assert!(loaded.share("hull") > 0.05 && loaded.share("gauss") > 0.4, "{pack}");
        }
    }
}

/// A joint that follows another turns with it: by −0.5 rad for each, and 0.1 more.
#[test]
fn robots_turn_at_their_sliders() {
    let [robot, mesh] =
        ["crowd.urdf", "meshes/bracket.obj"].map(|name| text(workspace().join("tests/robots").join(name)));
    let folder = folder(&[("in/crowd.urdf", &robot), ("in/meshes/bracket.obj", &mesh)]);
    run(&folder, &["robot", "in/crowd.urdf", "--out", "out", "--report", "robot.html"]).expect(0);
    let Some(browser) = browser() else { return };
    let act = "const pixels = () => document.getElementById('hull').toDataURL();
        const slider = document.querySelectorAll('#joints input')[2], before = pixels();
        slider.value = 0.6; slider.dispatchEvent(new Event('input'));
        requestAnimationFrame(() => requestAnimationFrame(() => {
          document.documentElement.dataset.moved = pixels() !== before;
          document.documentElement.dataset.joints = [...document.querySelectorAll('#joints output')].map((output) => output.textContent);
        }));";
    let loaded = acted(browser, &folder.path().join("robot.html"), act);
    loaded.assert_sound();
    assert_eq!(loaded.attribute("html ", "data-moved"), "true");
    assert_eq!(loaded.attribute("html ", "data-joints"), "0.0°,0.0°,34.4°,−11.5°");
    assert!(loaded.share("hull") > 0.02);
}
