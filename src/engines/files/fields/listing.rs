//! All parameters with their values, as reports list them.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::table::{FieldTable, Group, Place, capital, named_unit, text_of};
use super::{Kind, get, steps};

/// The parameters of a report: a tree of keys and values for programs, which is what is serialised, and a list for
/// people.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct ParameterList {
    /// The parameters as the project file has them.
    pub tree: Value,
    /// The parameters that count, in the order of the forms; what no form shows comes last.
    #[serde(skip)]
    pub entries: Vec<Entry>,
}

/// A parameter with its value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Heading.
    pub group: &'static str,
    /// Key.
    pub key: String,
    /// Name.
    pub label: String,
    /// Name in the papers; may be empty.
    pub symbol: &'static str,
    /// The value as a reader sees it.
    pub value: String,
    /// Unit; may be empty.
    pub unit: &'static str,
    /// Whether the value is the default.
    pub is_default: bool,
}

/// Heading of values that no field describes, such as decisions of the user.
const OTHERS: &str = "Others";

impl<P: Serialize + DeserializeOwned> FieldTable<P> {
    /// Every parameter with its value. Fields that do not count are in the tree alone.
    pub fn list(&self, params: &P) -> ParameterList {
        let (tree, defaults) = (self.values(params), self.values(&self.defaults(params)));
        let mut entries = Vec::new();
        for group in self.groups {
            let heading = if group.name.is_empty() { group.section } else { group.name };
            for field in group.fields.iter().filter(|field| field.is_shown(&tree)) {
                let is_default = get(&tree, field.key) == get(&defaults, field.key);
                let place = Place { field, key: field.key.to_owned(), label: field.label.to_owned() };
                add_entries(&mut entries, heading, &place, get(&tree, field.key), is_default);
            }
        }
        add_others(&mut entries, self.groups, "", &tree);
        ParameterList { tree, entries }
    }
}

impl ParameterList {
    /// This list without the parameter, or the table of parameters, under `key`.
    #[must_use]
    pub fn without(mut self, key: &str) -> Self {
        let (table, last) = key.rsplit_once('.').unwrap_or(("", key));
        let pointer = steps(table).map(|step| format!("/{step}")).collect::<String>();
        if let Some(table) = self.tree.pointer_mut(&pointer).and_then(Value::as_object_mut) {
            table.remove(last);
        }
        self.entries.retain(|entry| !is_within(&entry.key, key));
        self
    }

    /// The parameters of the table under `key` alone.
    #[must_use]
    pub fn of_table(mut self, key: &str) -> Self {
        self.entries.retain(|entry| is_within(&entry.key, key));
        Self { tree: get(&self.tree, key).clone(), ..self }
    }
}

/// Whether `key` is `outer` or lies in the table or list of that name.
fn is_within(key: &str, outer: &str) -> bool {
    key.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

fn add_entries(all: &mut Vec<Entry>, group: &'static str, place: &Place, value: &Value, is_default: bool) {
    let Place { field, key, label } = place;
    if let (Kind::Rows { fields, .. }, Some(rows)) = (field.kind, value.as_array()) {
        for (i, row) in rows.iter().enumerate() {
            for field in fields.iter().filter(|field| field.is_shown(row)) {
                let key = format!("{key}[{i}].{}", field.key);
                let place = Place { field, key, label: format!("{label} {}, {}", i + 1, field.label) };
                add_entries(all, group, &place, get(row, field.key), is_default);
            }
        }
        return;
    }
    // A unit belongs to a number.
    let unit = if value.is_number() || value.is_array() { field.unit } else { "" };
    let value = field.show_label(value);
    all.push(Entry { group, key: key.clone(), label: label.clone(), symbol: field.symbol, value, unit, is_default });
}

/// Adds the values in `value`, which is under `key`, that no field describes. What is empty is left out.
fn add_others(all: &mut Vec<Entry>, groups: &[Group], key: &str, value: &Value) {
    let mut fields = groups.iter().flat_map(|group| group.fields);
    let describes = |field: &super::Field| match field.kind {
        Kind::Variant { tag, .. } => key.strip_prefix(field.key) == Some(&*format!(".{tag}")),
        // A field may stand for one of the numbers in a list.
        _ => field.key == key || (value.is_array() && is_within(field.key, key)),
    };
    if !key.is_empty() && fields.any(describes) {
        return;
    }
    let text = match value {
        Value::Object(table) => {
            for (name, inner) in table {
                let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                add_others(all, groups, &key, inner);
            }
            return;
        }
        Value::Null => return,
        Value::Array(items) => items.iter().map(text_of).collect::<Vec<_>>().join("; "),
        other => text_of(other),
    };
    if !text.is_empty() {
        let (name, unit) = named_unit(key);
        let label = capital(&steps(name).collect::<Vec<_>>().join(", ").replace('_', " "));
        let key = key.to_owned();
        all.push(Entry { group: OTHERS, key, label, symbol: "", value: text, unit, is_default: false });
    }
}
