//! Answers in Python and TypeScript are made from `hullmap.h`: names, types and comments. With
//! `HULLMAP_RENEW` set, the test writes them instead of comparing; the script `header` does so.

use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

/// Answers in Python; in TypeScript those with a name there, and the name for many, if it exists.
const ANSWERS: [(&str, Option<Option<&str>>); 8] = [
    ("Intersection", Some(Some("Intersections"))),
    ("Distance", Some(Some("Distances"))),
    ("Contact", Some(Some("Contacts"))),
    ("RayHit", Some(Some("RayHits"))),
    ("Impact", Some(None)),
    ("SignedDistance", None),
    ("TimeOfImpact", Some(None)),
    ("Clearance", None),
];
/// Words in Python, and whether they are in TypeScript.
const WORDS: [(&str, bool); 4] =
    [("Status", true), ("Overlap", true), ("Verdict", false), ("Differentiability", false)];
/// Fields for functions of `hullmap` alone.
const HIDDEN: [&str; 2] = ["features", "is_only_normal"];
const HIT: &str = "True unless the shapes are certainly separated: touching and undecided pairs count as hits.";
const LINE: usize = 100;

/// An enum or a struct of the header. The type of a variant is its number.
struct Item {
    comment: String,
    fields: Vec<Field>,
}

struct Field {
    name: String,
    kind: String,
    /// The first paragraph of the comment.
    comment: String,
}

/// Comment lines that end the text, as one line for each paragraph.
fn paragraphs(lines: &[&str]) -> Vec<String> {
    let start = lines.iter().rposition(|line| !line.trim_start().starts_with("//")).map_or(0, |at| at + 1);
    let lines = lines[start..].iter().map(|line| line.trim_start().trim_start_matches('/').trim());
    lines.collect::<Vec<_>>().split(|line| line.is_empty()).map(|lines| lines.join(" ")).collect()
}

impl Item {
    /// The item of the header that has this line.
    fn find(header: &str, line: &str) -> Self {
        let has_line = |item: &&str| item.lines().any(|own| own == line);
        let lines: Vec<&str> = header.split("\n\n").find(has_line).expect(line).lines().collect();
        let start = lines.iter().position(|line| !line.starts_with("//")).expect(line);
        let comment = paragraphs(&lines[..start]).into_iter().take(2).collect::<Vec<_>>().join(" ");
        let mut fields = Vec::new();
        for (at, line) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("    ")) {
            let member = line.trim().trim_end_matches([',', ';']);
            if member.starts_with("//") {
                continue;
            }
            let (kind, name) = match member.split_once(" = ") {
                Some((name, number)) => (number, name),
                None => member.split_once(' ').expect(member),
            };
            let (name, kind) = name.strip_suffix("[2]").map_or((name, kind), |name| (name, "pair"));
            let comment = paragraphs(&lines[..at]).remove(0);
            fields.push(Field { name: name.to_owned(), kind: kind.to_owned(), comment });
        }
        assert!(!fields.is_empty() && !comment.is_empty(), "{line}");
        Self { comment, fields }
    }

    fn of_words(header: &str, name: &str) -> Self {
        Self::find(header, &format!("enum Hullmap{name}"))
    }

    /// The answer as bindings have it.
    fn of_answer(header: &str, name: &str) -> Self {
        let mut found = Self::find(header, &format!("}} Hullmap{name};"));
        found.fields.retain(|field| !HIDDEN.contains(&&*field.name));
        if name == "Intersection" {
            found.fields.insert(0, Field { name: "hit".into(), kind: "bool".into(), comment: HIT.into() });
        }
        found
    }
}

/// The comment, with each word that is a name of C replaced.
fn translated(comment: &str, name: impl Fn(&str) -> String) -> String {
    let mut found = String::new();
    for piece in comment.split_inclusive(|c: char| !(c.is_alphanumeric() || "_.`()".contains(c))) {
        let word = piece.trim_end_matches(|c: char| !(c.is_alphanumeric() || c == '_' || c == '`' || c == ')'));
        let is_name = word.to_lowercase().starts_with("hullmap") || word.starts_with('`') && word.ends_with('`');
        found += &if is_name { name(word) } else { word.to_owned() };
        found += &piece[word.len()..];
    }
    found
}

/// Text in lines of at most `LINE` columns, each after `before`.
fn filled(text: &str, before: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ').map(|word| word.replace('\u{a0}', " ")) {
        let line = lines.last_mut().unwrap();
        if before.len() + line.chars().count() + word.chars().count() >= LINE {
            lines.push(word);
        } else {
            *line += if line.is_empty() { "" } else { " " };
            *line += &word;
        }
    }
    lines.join(&format!("\n{before}"))
}

/// A name of C in Python.
fn python_name(word: &str) -> String {
    for (words, _) in WORDS {
        if let Some(variant) = word.strip_prefix(&format!("HULLMAP_{}_", words.to_uppercase())) {
            return format!("`{words}.{variant}`");
        }
    }
    match (word.strip_prefix("hullmap_"), word.split_once('.')) {
        (Some(function), _) => format!("`{}`", function.trim_end_matches("()")),
        (None, Some((_, field))) => format!("``{field}``"),
        _ => format!("`{word}`"),
    }
}

fn python(header: &str) -> String {
    let mut text = String::from(
        "\"\"\"Answers: a class for each query, with an array for each field.\n\nMade from hullmap.h by \
         crates/hullmap-c/header: do not edit.\"\"\"\n\nfrom __future__ import annotations\n\nfrom dataclasses import \
         dataclass\n\nfrom ._arrays import Counts, Floats\nfrom ._results import Codes, Flags, _Answer, _Words\n",
    );
    let comment = |comment: &str, more: &str| {
        let text = translated(comment, python_name) + more;
        format!("    \"\"\"{}\"\"\"\n", filled(&text, "    ").replace('\\', "\\\\"))
    };
    for (name, _) in WORDS {
        let item = Item::of_words(header, name);
        write!(text, "\n\nclass {name}(_Words):\n{}\n", comment(&item.comment, "")).unwrap();
        for Field { name: variant, kind, comment: own } in &item.fields {
            let variant = variant.strip_prefix(&format!("HULLMAP_{}_", name.to_uppercase())).expect(variant);
            write!(text, "    {variant} = {kind}\n{}", comment(own, "")).unwrap();
        }
    }
    for (name, _) in ANSWERS {
        let item = Item::of_answer(header, name);
        let of_item = comment(&item.comment, "");
        write!(text, "\n\n@dataclass(frozen=True, eq=False, repr=False)\nclass {name}(_Answer):\n{of_item}\n").unwrap();
        for Field { name, kind, comment: own } in &item.fields {
            let (array, more) = match &**kind {
                "bool" => ("Flags", String::new()),
                "double" => ("Floats", String::new()),
                "uint32_t" => ("Counts", String::new()),
                "pair" => ("Counts", " (...,\u{a0}2)".to_owned()),
                "HullmapVec3" => ("Floats", " (...,\u{a0}3)".to_owned()),
                words => ("Codes", format!(" Codes of `{}`.", words.strip_prefix("Hullmap").expect(words))),
            };
            write!(text, "    {name}: {array}\n{}", comment(own, &more)).unwrap();
        }
    }
    text
}

/// `depth_lower` as `depthLower`.
fn camel(name: &str) -> String {
    let mut words = name.split('_');
    let first = words.next().unwrap_or_default().to_owned();
    words.fold(first, |name, word| name + &word[..1].to_uppercase() + &word[1..])
}

/// A name of C in TypeScript.
fn typescript_name(word: &str) -> String {
    for (words, _) in WORDS {
        if let Some(variant) = word.strip_prefix(&format!("HULLMAP_{}_", words.to_uppercase())) {
            return format!("`{}`", variant.to_lowercase());
        }
    }
    let name = word.split_once('.').map_or(word, |(_, field)| field);
    format!("`{}`", camel(name.trim_matches('`').trim_start_matches("hullmap_").trim_end_matches("()")))
}

fn typescript(header: &str) -> String {
    let mut text = String::from("// Made from hullmap.h by crates/hullmap-c/header: do not edit.\n");
    let comment = |comment: &str, indent: &str| {
        let own = translated(comment, typescript_name);
        if indent.len() + own.chars().count() + 7 <= LINE {
            return format!("{indent}/** {own} */\n");
        }
        format!("{indent}/**\n{indent} * {}\n{indent} */\n", filled(&own, &format!("{indent} * ")))
    };
    for (name, _) in WORDS.iter().filter(|(_, is_used)| *is_used) {
        let item = Item::of_words(header, name);
        let prefix = format!("HULLMAP_{}_", name.to_uppercase());
        let word = |field: &Field| {
            format!("\n{}    | \"{}\"", comment(&field.comment, "    "), field.name.replace(&prefix, "").to_lowercase())
        };
        let words: String = item.fields.iter().map(word).collect();
        write!(text, "\n{}export type {name} ={words};\n", comment(&item.comment, "")).unwrap();
    }
    for (name, many) in ANSWERS.into_iter().filter_map(|(name, many)| Some((name, many?))) {
        let item = Item::of_answer(header, name);
        let mut interface = |name: &str, about: &str, is_many: bool| {
            write!(text, "\n{}export interface {name} {{\n", comment(about, "")).unwrap();
            for Field { name, kind, comment: own } in &item.fields {
                let kind = match (&**kind, is_many) {
                    ("bool", false) => "boolean".to_owned(),
                    ("bool", true) => "Uint8Array".to_owned(),
                    ("double" | "uint32_t", false) => "number".to_owned(),
                    ("uint32_t", true) | ("pair", _) => "Uint32Array".to_owned(),
                    ("double", true) | ("HullmapVec3", _) => "Float64Array".to_owned(),
                    (words, _) => {
                        words.strip_prefix("Hullmap").expect(words).to_owned() + if is_many { "[]" } else { "" }
                    }
                };
                let own = if is_many { String::new() } else { comment(own, "    ") };
                writeln!(text, "{own}    {}: {kind};", camel(name)).unwrap();
            }
            text += "}\n";
        };
        if name != "Intersection" {
            interface(name, &item.comment, false);
        }
        if let Some(many) = many {
            let about = "Answers of many queries, as one array for each field: three numbers for a vector, two indices \
                         for `parts`, and 1 or 0 for `hit`.";
            interface(many, about, true);
        }
    }
    text
}

#[test]
#[expect(clippy::disallowed_methods, reason = "a script sets the variable")]
fn answers_in_other_languages_are_those_of_the_header() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let header = fs::read_to_string(crates.join("hullmap-c/include/hullmap.h")).unwrap();
    for (file, made) in [
        ("hullmap-python/python/hullmap/_answers.py", python(&header)),
        ("hullmap-wasm/src/answers.d.ts", typescript(&header)),
    ] {
        if env::var_os("HULLMAP_RENEW").is_some() {
            fs::write(crates.join(file), made).unwrap();
        } else {
            let found = fs::read_to_string(crates.join(file)).expect(file);
            assert!(found == made, "{file} is stale: run crates/hullmap-c/header");
        }
    }
}

/// A field of an answer is written by hand in one place: the file of its struct.
#[test]
fn bindings_do_not_list_fields() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut read = 0;
    let folders = [
        "hullmap-c/src",
        "hullmap-c/src/types",
        "hullmap-python/src",
        "hullmap-python/python/hullmap",
        "hullmap-wasm/src",
    ];
    for entry in folders.iter().flat_map(|folder| fs::read_dir(crates.join(folder)).unwrap()) {
        let path = entry.unwrap().path();
        let file = path.file_name().unwrap().to_str().unwrap();
        // The last one makes answers of the GPU's.
        if !path.is_file() || ["_answers.py", "answers.d.ts", "gpu.rs"].contains(&file) {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let found = code.filter(|line| line.contains("depth_upper") || line.contains("depthUpper")).count();
        assert_eq!(found, 0, "{}", path.display());
        read += 1;
    }
    assert!(read > 50, "{read}");
}
