//! HTML: escaping, templates, numbers as text.

use serde::Serialize;

pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in plain(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// Control characters, which HTML forbids, become their pictures; characters that change the text
/// direction, and could disguise a name, become U+FFFD.
pub fn plain(text: &str) -> String {
    let shown = |c: char| match c {
        // U+2400 to U+241F are pictures of the control characters.
        '\0'..'\u{20}' => char::from_u32(0x2400 + u32::from(c)).unwrap_or(' '),
        '\u{7f}'..='\u{9f}' => '\u{2421}',
        '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => '\u{fffd}',
        c => c,
    };
    text.chars().map(shown).collect()
}

/// A sentence in which the option that it recommends stays in one piece.
pub fn sentence(text: &str) -> String {
    escape(text).replace("--decompose", "<code>--decompose</code>")
}

/// A value as JSON for a `script` element: `<` is escaped so that no tag can begin.
pub fn json(value: &impl Serialize) -> String {
    // In JSON, `<` occurs only in strings.
    serde_json::to_string(value).expect("plain data with text keys").replace('<', "\\u003c")
}

/// A path as a link, percent-encoded, with `/` between folders.
pub fn link(path: &str) -> String {
    let mut out = String::new();
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' | b'/' => out.push(char::from(byte)),
            _ => out.push_str(&format!("%{byte:02X}")),
        }
    }
    out
}

/// Replaces each `{{name}}` in a template by its value. Values are not expanded again. Panics if
/// the template has a name without a value: a bug.
pub fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut out = String::with_capacity(template.len() + values.iter().map(|(_, value)| value.len()).sum::<usize>());
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").expect("a placeholder ends");
        let value = values.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("no value for {name}"));
        out.push_str(before);
        out.push_str(value.1);
        rest = after;
    }
    out.push_str(rest);
    out
}

/// Entries of a list of facts: names and values.
pub fn facts(rows: &[(&str, String)]) -> String {
    rows.iter().map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n")).collect()
}

/// A table that scrolls within the page. `heads` are divided by ` | `; a column of words has a
/// colon behind its head. Rows have attributes of their element and cells of HTML; the last row may
/// be the sums.
pub fn table(label: &str, heads: &str, rows: &[(String, Vec<String>)], has_sums: bool) -> String {
    let class = |head: &str| match head {
        "hull:" | "part:" | "link:" => " class=\"word name\"",
        _ if head.ends_with(':') => " class=\"word\"",
        _ => "",
    };
    let mut out = format!(
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{label}\"><table aria-label=\"{label}\">\n<thead><tr>"
    );
    for head in heads.split(" | ") {
        out += &format!("<th scope=\"col\"{}>{}</th>", class(head), head.trim_end_matches(':'));
    }
    out += "</tr></thead>\n<tbody>\n";
    for (at, (attributes, cells)) in rows.iter().enumerate() {
        if has_sums && at + 1 == rows.len() {
            out += "</tbody>\n<tfoot>\n";
        }
        out += &format!("<tr{attributes}>");
        for (cell, head) in cells.iter().zip(heads.split(" | ")) {
            out += &format!("<td{}>{cell}</td>", class(head));
        }
        out += "</tr>\n";
    }
    out + if has_sums { "</tfoot></table></div>\n" } else { "</tbody>\n</table></div>\n" }
}

/// A cell that is a button, pressed as long as its row is shown.
pub fn button(content: &str) -> String {
    format!("<button type=\"button\" aria-pressed=\"false\">{content}</button>")
}

/// The section about what a page lacks; empty if that is nothing.
pub fn left_out(list: &[String]) -> String {
    if list.is_empty() {
        return String::new();
    }
    let items: String = list.iter().map(|item| format!("<p>{}</p>\n", escape(item))).collect();
    format!(
        "<section aria-labelledby=\"limits-title\">\n<h2 id=\"limits-title\">What is left out</h2>\n{items}</section>\n"
    )
}

/// A value in words, or a dash if it is not known.
pub fn or_dash<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), text)
}

/// Source, options and format of a file: the line below the title.
pub fn origin(found: Option<&str>, recorded: &str, options: &str, format_version: u32) -> String {
    let source = match found {
        Some(source) => format!("source {}", escape(source)),
        None if recorded.is_empty() => "no source found".to_owned(),
        None => format!("source {} not found", escape(recorded)),
    };
    format!("{source} · options: {} · format {format_version}", escape(options))
}

/// A share in per cent, with about two digits.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        0.005.. if percent < 1.0 => format!("{percent:.2}\u{a0}%"),
        1.0.. if percent < 9.95 => format!("{percent:.1}\u{a0}%"),
        9.95.. => format!("{}\u{a0}%", count(percent.round() as u64)),
        _ if percent.is_nan() => "?".to_owned(),
        _ => "less than 0.01\u{a0}%".to_owned(),
    }
}

/// A number of bytes in the largest unit that leaves a whole.
pub fn size(bytes: usize) -> String {
    match bytes {
        0..1_000 => format!("{bytes}\u{a0}bytes"),
        1_000..1_000_000 => format!("{:.0}\u{a0}kB", bytes as f64 / 1e3),
        _ => format!("{:.1}\u{a0}MB", bytes as f64 / 1e6),
    }
}

/// A number with at most four significant digits.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..7.0).contains(&magnitude) {
        let text = format!("{value:.2e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
        return format!("{digits}e{exponent}").replace('-', "−");
    }
    let decimals = (3.0 - magnitude).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    let (sign, text) = text.strip_prefix('-').map_or(("", text), |rest| ("−", rest));
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let dot = if fraction.is_empty() { "" } else { "." };
    format!("{sign}{}{dot}{fraction}", count(whole.parse().unwrap_or(0)))
}

/// Groups of three digits, with narrow no-break spaces.
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(2 * digits.len());
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_leave_its_element() {
        assert_eq!(escape("<b a=\"x\" c='y'>&amp;"), "&lt;b a=&quot;x&quot; c=&#39;y&#39;&gt;&amp;amp;");
        assert_eq!(escape("zero\0 tab\t del\u{7f} \u{202e}gpj"), "zero␀ tab␉ del␡ \u{fffd}gpj");
        assert_eq!(escape("Ünï ☃ 石"), "Ünï ☃ 石");
        assert_eq!(json(&"</script><!--"), "\"\\u003c/script>\\u003c!--\"");
        assert_eq!(link("a b/ü#1?.html"), "a%20b/%C3%BC%231%3F.html");
    }

    #[test]
    fn values_are_not_expanded() {
        assert_eq!(fill("<{{a}}|{{b}}>", &[("a", "{{b}}"), ("b", "1")]), "<{{b}}|1>");
    }

    #[test]
    fn numbers_for_people() {
        let shown = [0.0, 1.0, 1234567.0, 0.123456, -2.5, 1e-7, 1e9, 99.999].map(short);
        assert_eq!(shown, ["0", "1", "1\u{202f}234\u{202f}567", "0.1235", "−2.5", "1e−7", "1e9", "100"]);
        assert_eq!([f64::NAN, f64::INFINITY].map(short), ["NaN", "inf"]);
        let shares = [0.0, 1e-5, 0.0012, 0.0999, 4.38, f64::NAN].map(percent);
        let shown = ["less than 0.01 %", "less than 0.01 %", "0.12 %", "10 %", "438 %", "?"];
        assert_eq!(shares.map(|text| text.replace('\u{a0}', " ")), shown);
        let sizes = [999, 1_512, 2_500_000].map(|bytes| size(bytes).replace('\u{a0}', " "));
        assert_eq!(sizes, ["999 bytes", "2 kB", "2.5 MB"]);
    }
}
