//! Reports as self-contained HTML pages, made by templates from serialisable structs.
//!
//! A template extends `page.html.jinja`, which is the skeleton with the one stylesheet, and may import the macros of
//! `kit.html.jinja`: tables, banners, figures. Whatever it writes is escaped, unless it says `|safe`, which is for SVG
//! pictures that this program drew. What it names and the report does not have is an error and no gap in the page.
//!
//! Filters beside those of the language:
//! - `number(decimals)`: a number with a real minus sign, a dash where there is none;
//! - `small`: four decimals, or an exponent where these would say nothing;
//! - `numbers(decimals)`: several of them with commas between, a dash where there are none;
//! - `point`: the numbers of a point with three decimals;
//! - `file_name`: the last part of a path in either system's notation.

pub mod plot;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Serde, Value};
use minijinja::{AutoEscape, Environment, Error, ErrorKind, Output, State, UndefinedBehavior};
use serde::{Serialize, Serializer};

/// The stylesheet of all reports: light, dark and paper.
pub const STYLE: &str = include_str!("report.css");

/// A template: what errors call it, and its text.
#[derive(Debug, Clone, Copy)]
pub struct Template {
    /// Name, as in `verify.html.jinja`.
    pub name: &'static str,
    /// Text.
    pub text: &'static str,
}

/// A picture on a page.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Picture {
    /// Name of its file beside the report; empty where it has none.
    pub file: String,
    /// Title: the content of the picture in a few words.
    pub title: String,
    /// What is to be seen in it, in a sentence or two.
    pub caption: String,
    /// Legend: colours in CSS notation and what each stands for.
    pub legend: Vec<(String, String)>,
    /// The image as PNG bytes, the `url` of templates.
    #[serde(rename = "url", serialize_with = "png_url")]
    pub png: Vec<u8>,
}

/// For fields that hold a PNG image: the address of a picture in templates.
///
/// # Errors
/// The serializer's own.
pub fn png_url<S: Serializer>(png: &[u8], to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&data_url("image/png", png))
}

/// A page that could not be made: the template names what the report does not have.
#[derive(Debug, thiserror::Error)]
#[error(
    "{template}: {}{problem}; this is a fault of the program, please report it",
    line.map_or(String::new(), |n| format!("line {n}: "))
)]
pub struct PageError {
    /// The template.
    pub template: String,
    /// Line, counted from 1.
    pub line: Option<usize>,
    /// What is wrong.
    pub problem: String,
}

/// The page that `template` makes of `report`.
///
/// # Errors
/// [`PageError`], which a test that makes each report once keeps from happening.
pub fn page(template: &Template, report: &impl Serialize) -> Result<String, PageError> {
    let wrong = |error: Error| PageError {
        template: error.name().unwrap_or(template.name).to_owned(),
        line: error.line(),
        problem: error.detail().map_or_else(|| error.kind().to_string(), str::to_owned),
    };
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.set_formatter(write_escaped);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    let mut syntax = SyntaxConfig::builder();
    // Lines that hold only a statement leave nothing in the page.
    syntax.trim_blocks(true).lstrip_blocks(true);
    environment.set_syntax(syntax.build().map_err(wrong)?);
    environment.add_global("style", Value::from_safe_string(STYLE.to_owned()));
    environment.add_filter("number", |value: &Value, decimals: usize| figure(value, |n| number(n, decimals.min(12))));
    environment.add_filter("small", |value: &Value| figure(value, small));
    environment.add_filter("numbers", |value: &Value, decimals: usize| numbers(value, decimals));
    environment.add_filter("point", |value: &Value| numbers(value, 3));
    environment.add_filter("file_name", |path: &str| file_name(path).to_owned());
    for (name, text) in [
        ("page.html.jinja", include_str!("page.html.jinja")),
        ("kit.html.jinja", include_str!("kit.html.jinja")),
        (template.name, template.text),
    ] {
        environment.add_template(name, text).map_err(wrong)?;
    }
    let page = environment.get_template(template.name).map_err(wrong)?;
    page.render(Value::from(Serde(report))).map_err(wrong)
}

/// Writes a value as the page shows it.
fn write_escaped(out: &mut Output, state: &mut State, value: &Value) -> Result<(), Error> {
    match value.as_str() {
        Some(text) if !value.is_safe() && matches!(state.auto_escape(), AutoEscape::Html) => {
            out.write_str(&escape(text)).map_err(Error::from)
        }
        _ => minijinja::escape_formatter(out, state, value),
    }
}

fn figure(value: &Value, shown: impl Fn(f64) -> String) -> Result<String, Error> {
    if value.is_undefined() {
        return Err(ErrorKind::UndefinedError.into());
    }
    if value.is_none() {
        return Ok(NO_NUMBER.to_owned());
    }
    let number = f64::try_from(value.clone());
    let wrong = |_| Error::new(ErrorKind::InvalidOperation, format!("a number is needed, not {}", value.kind()));
    number.map(shown).map_err(wrong)
}

fn numbers(value: &Value, decimals: usize) -> Result<String, Error> {
    if value.is_undefined() || value.is_none() {
        return figure(value, small);
    }
    let texts = value.try_iter()?.map(|v| figure(&v, |n| number(n, decimals.min(12))));
    Ok(texts.collect::<Result<Vec<_>, Error>>()?.join(", "))
}

/// What stands where there is no number.
const NO_NUMBER: &str = "\u{2013}";

/// `text` safe to stand in HTML or SVG, in content and in quoted attributes.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c if c.is_control() && c != '\n' && c != '\t' => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// A count with its noun, which takes an s: `1 place`, `2 places`.
pub fn counted(n: usize, one: &str) -> String {
    if n == 1 { format!("1 {one}") } else { format!("{n} {one}s") }
}

/// A number with so many decimals and a real minus sign, without a signed zero.
pub fn number(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return NO_NUMBER.to_owned();
    }
    let text = format!("{value:.decimals$}");
    let is_zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
    if is_zero { text.replace('-', "") } else { text.replace('-', "\u{2212}") }
}

/// A number of any size: four decimals, or an exponent where these would say nothing.
pub fn small(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) || !value.is_finite() {
        number(value, 4)
    } else {
        format!("{value:.2e}").replace('-', "\u{2212}")
    }
}

/// A field of a CSV file (RFC 4180).
pub fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// The last part of a path in either system's notation.
pub fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// `bytes` as the address of a picture that stands in the page itself.
pub fn data_url(media_type: &str, bytes: &[u8]) -> String {
    format!("data:{media_type};base64,{}", STANDARD.encode(bytes))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn made(text: &'static str, report: &impl Serialize) -> Result<String, PageError> {
        page(&Template { name: "test.html.jinja", text }, report)
    }

    const ALL: &str = "{% extends 'page.html.jinja' %}{% import 'kit.html.jinja' as kit %}\n\
        {% block title %}{{ name }}{% endblock %}\n\
        {% block body %}{{ kit.banner(ok, 'Verified.', name) }}\
        {{ kit.pairs('Facts', [['Name', name], ['Length', -1.25|number(1)]]) }}\
        {% set head = ['name', '#mm'] %}{% call kit.table('', 'Rows', head) %}\
        {% for cells in rows %}{{ kit.row(head, cells) }}{% endfor %}{% endcall %}\
        {{ kit.header('Head', name, ok, name) }}{{ kit.key([['none', none|number(1), 'x'], ['two', 2, 'mm']]) }}\
        {{ kit.parameters(entries) }}\
        {{ kit.figure(picture) }}<div class=\"plot\">{{ plot|safe }}</div>{% endblock %}\
        {% block footer %}Sparkpath{% endblock %}";

    #[test]
    fn a_page_escapes_what_it_is_given_and_needs_nothing_from_outside() {
        let hostile = "<script>alert('x')</script>\"&\u{0}{{ 7 * 7 }}";
        let html = made(
            ALL,
            &json!({
                "name": hostile, "ok": true, "rows": [[hostile, "1"], ["b", "2"]], "plot": "<svg></svg>",
                "picture": {
                    "title": hostile, "caption": hostile, "url": data_url("image/png", b"x"),
                    "legend": [["#fff", hostile]],
                },
                "entries": [{
                    "group": hostile, "label": hostile, "symbol": "", "value": hostile, "unit": "", "is_default": true,
                }],
            }),
        )
        .unwrap();
        assert!(!html.contains("<script") && !html.contains('\u{0}') && !html.contains("http") && !html.contains("49"));
        assert_eq!(html.matches("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&quot;&amp;").count(), 13);
        assert!(html.starts_with("<!doctype html>") && html.contains("<svg></svg>") && html.contains("\u{2212}1.2"));
        assert!(html.contains("src=\"data:image/png;base64,eA==\"") && html.contains("<td class=\"num\">2</td>"));
        assert!(html.contains(STYLE), "the stylesheet is in the page, as it is");
        assert!(html.contains("<dt>two</dt><dd>2 <small>mm</small>") && !html.contains("<dt>none</dt>"));
        for tag in ["html", "head", "body", "main", "table", "tr", "td", "th", "p", "figure", "footer", "span", "div"] {
            let opened = html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }

    #[test]
    fn parameters_stand_under_their_headings_with_symbol_and_unit() {
        let entry = |[group, label, symbol, value, unit]: [&str; 5], is_default: bool| {
            json!({
                "group": group, "label": label, "symbol": symbol, "value": value, "unit": unit,
                "is_default": is_default,
            })
        };
        let entries = [
            entry(["Path", "Step <k>", "k", "0.5", "mm"], false),
            entry(["Path", "Kept", "", "", ""], true),
            entry(["Checks", "Depth", "", "<none>", ""], true),
        ];
        let text = "{% import 'kit.html.jinja' as kit %}{{ kit.parameters(entries) }}";
        let page = made(text, &json!({ "entries": entries })).unwrap();
        assert!(page.contains("<caption>Path</caption>") && page.contains("<caption>Checks</caption>"), "{page}");
        assert!(page.contains("<td>Step &lt;k&gt; <small>k</small></td><td><b>0.5</b> mm</td>"), "{page}");
        assert!(page.contains("<td>Kept</td><td>\u{2013}</td>") && page.contains("<td>&lt;none&gt;</td>"), "{page}");
        for tag in ["table", "tbody", "tr", "td", "div", "p"] {
            let opened = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
        }
        assert_eq!(page.matches("<table").count(), 2);
    }

    #[test]
    fn rows_without_a_value_are_left_out_and_a_list_has_a_row_for_each() {
        let text = "{% import 'kit.html.jinja' as kit %}{% call kit.pairs('', [['a', none], ['b', ['<1>', '2']], ['c', kit.code('x')]]) %}{{ kit.pair('d', '3') }}{% endcall %}";
        let html = made(text, &json!({})).unwrap();
        let cells: Vec<&str> = html.split("<td>").skip(1).filter_map(|cell| cell.split("</td>").next()).collect();
        assert_eq!(cells, ["b", "&lt;1&gt;", "b", "2", "c", "<code>x</code>", "d", "3"]);
    }

    #[test]
    fn what_a_report_does_not_have_is_an_error_with_its_line() {
        for text in [
            "a\n{{ nothing }}",
            "a\n{{ nothing|number(2) }}",
            "a\n{{ name|number(2) }}",
            "a\n{% include 'b' %}",
            "a\n{% if %}",
        ] {
            let error = made(text, &json!({"name": "x"})).unwrap_err();
            assert_eq!((error.line, &*error.template), (Some(2), "test.html.jinja"), "{text}: {error}");
        }
    }

    #[test]
    fn numbers_have_a_real_minus_and_no_signed_zero() {
        assert_eq!(number(-1.25, 1), "\u{2212}1.2");
        assert_eq!(number(-0.0001, 2), "0.00");
        assert_eq!(number(f64::NAN, 2), "\u{2013}");
        assert_eq!(
            (small(0.0), small(12.0), small(-1e-7)),
            ("0.0000".into(), "12.0000".into(), "\u{2212}1.00e\u{2212}7".into())
        );
        assert_eq!(
            made("{{ n|number(2) }} {{ n|small }} {{ p|point }}", &json!({"n": null, "p": [1, -2.0, 0.5]})).unwrap(),
            "\u{2013} \u{2013} 1.000, \u{2212}2.000, 0.500"
        );
        let none = made("{{ n|point }} {{ p|numbers(1) }}", &json!({"n": null, "p": [1, -2.0]}));
        assert_eq!(none.unwrap(), "\u{2013} 1.0, \u{2212}2.0");
    }

    #[test]
    fn base64_matches_the_vectors_of_rfc_4648() {
        for (plain, coded) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("fooba", "Zm9vYmE=")]
        {
            assert_eq!(data_url("text/plain", plain.as_bytes()), format!("data:text/plain;base64,{coded}"));
        }
        assert!(data_url("image/png", &[0xfb, 0xff, 0xfe]).ends_with("+//+"));
    }

    #[test]
    fn a_file_name_is_the_last_part() {
        assert_eq!(file_name("/a/b/part.stl"), "part.stl");
        assert_eq!(file_name("C:\\a\\part.stl"), "part.stl");
        assert_eq!(file_name("part.stl"), "part.stl");
    }
}
