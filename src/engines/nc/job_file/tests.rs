use super::*;
use crate::burn_table::BurnTable;
use crate::electrode_fixtures::set;
use crate::template::Templated as _;
use mold::datum::Datum;
use mold::opening::Opening;
use serde_json::Value;

fn job() -> JobFile {
    let table = BurnTable::of(&set(), "shell <1> & \"2\"", Opening::PlusZ, &Datum::default());
    let technology = JobTechnology {
        table: "built-in".to_owned(),
        id: "steel-copper".to_owned(),
        last_step: None,
        finish_vdi: None,
    };
    JobFile::of_table(&table, |name| vec![FileEntry::of(name, b"")], |_| Some(technology.clone()), |_| Vec::new())
}

/// Why `value` is not what `schema` asks for, by the keywords that [`SCHEMA`] uses but for `pattern`.
fn wrong(schema: &Value, value: &Value, root: &Value) -> Option<String> {
    if let Some(name) = schema["$ref"].as_str() {
        return wrong(root.pointer(name.strip_prefix('#').unwrap()).unwrap(), value, root);
    }
    if let Some(any) = schema["anyOf"].as_array() {
        let all: Option<Vec<String>> = any.iter().map(|schema| wrong(schema, value, root)).collect();
        return all.map(|why| why.join(" or "));
    }
    let is = |name: &str| match name {
        "null" => value.is_null(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_u64(),
        "array" => value.is_array(),
        "boolean" => value.is_boolean(),
        _ => value.is_object(),
    };
    let is_typed = match &schema["type"] {
        Value::String(name) => is(name),
        Value::Array(names) => names.iter().any(|name| is(name.as_str().unwrap())),
        _ => true,
    };
    let is_among = schema["enum"].as_array().is_none_or(|all| all.contains(value));
    let is_const = schema.get("const").is_none_or(|one| one == value);
    let has_length =
        schema["minItems"].as_u64().is_none_or(|n| value.as_array().is_none_or(|list| list.len() as u64 == n));
    let is_enough = schema["minimum"].as_f64().zip(value.as_f64()).is_none_or(|(least, v)| v >= least);
    let is_more = schema["exclusiveMinimum"].as_f64().zip(value.as_f64()).is_none_or(|(least, v)| v > least);
    if !(is_typed && is_among && is_const && has_length && is_enough && is_more) {
        return Some(format!("{value} is not {schema}"));
    }
    if let Some(items) = value.as_array() {
        return items.iter().find_map(|item| wrong(&schema["items"], item, root));
    }
    let keys = value.as_object()?;
    let properties = schema["properties"].as_object().unwrap();
    let missing = schema["required"].as_array().unwrap().iter().find(|key| !keys.contains_key(key.as_str().unwrap()));
    let unknown = keys.keys().find(|key| !properties.contains_key(*key));
    if missing.is_some() || unknown.is_some() {
        return Some(format!("missing {missing:?}, unknown {unknown:?} in {value}"));
    }
    keys.iter().find_map(|(key, value)| wrong(&properties[key], value, root))
}

#[test]
fn a_job_is_what_its_schema_asks_for() {
    let schema: Value = serde_json::from_str(SCHEMA).unwrap();
    let as_value = |job: &JobFile| -> Value { serde_json::from_str(&job.json().unwrap()).unwrap() };
    for example in JobFile::examples() {
        assert_eq!(wrong(&schema, &as_value(&example), &schema), None);
    }
    let job = as_value(&job());
    assert_eq!(wrong(&schema, &job, &schema), None);
    for (key, value) in [("/format", "other".into()), ("/electrodes/0/spark_gap_mm", Value::Null)] {
        let mut spoilt = job.clone();
        *spoilt.pointer_mut(key).unwrap() = value;
        assert!(wrong(&schema, &spoilt, &schema).is_some(), "{key}");
    }
}

#[test]
fn a_job_that_was_written_is_read_again_and_another_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("job.json");
    for job in JobFile::examples().into_iter().chain([job()]) {
        std::fs::write(&file, job.json().unwrap()).unwrap();
        assert_eq!(JobFile::read(&file).unwrap(), job);
    }
    let text = job().json().unwrap();
    for (from, to, words) in [
        (FORMAT, "other", "its format is \"other\""),
        ("spark_gap_mm", "gap", "unknown field `gap`"),
        ("{", "", "at line"),
    ] {
        std::fs::write(&file, text.replace(from, to)).unwrap();
        let said = JobFile::read(&file).unwrap_err().to_string();
        assert!(said.contains(words) && said.contains("export the job again"), "{said}");
    }
}

/// Of the three electrodes the third is blocked.
#[test]
fn a_mold_has_a_location_for_each_burn_of_a_released_electrode() {
    let job = job();
    let table = BurnTable::of(&set(), "", Opening::PlusZ, &Datum::default());
    assert_eq!(job.electrodes.len(), 2);
    for (electrode, entry) in job.electrodes.iter().zip(&table.electrodes) {
        assert_eq!((&electrode.name, electrode.spark_gap_mm), (&entry.name, entry.gap_mm));
        assert_eq!(electrode.locations.len(), entry.burns.len());
        for (location, burn) in electrode.locations.iter().zip(&entry.burns) {
            let position = location.position;
            assert_eq!([position.x_mm, position.y_mm, position.z_mm], [burn.x_mm, burn.y_mm, burn.z_mm]);
            assert_eq!(location.operations[0].minutes, burn.minutes);
            // It comes in against the direction in which it is lifted.
            let along: f64 = location.approach.unwrap().iter().zip(entry.lift).map(|(a, b)| a * b).sum();
            assert!((along + 1.0).abs() < 1e-6, "{along}");
        }
    }
    let ids = job.electrodes.iter().flat_map(|e| &e.locations).flat_map(|l| &l.operations).map(|o| o.id.as_str());
    let mut ids: Vec<&str> = ids.collect();
    let count = ids.len();
    assert_eq!(ids[0], "E1.L1.O1");
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "{ids:?}");
}

#[test]
fn xml_and_csv_hold_what_json_holds() {
    let job = job();
    let operations: usize = job.electrodes.iter().flat_map(|e| &e.locations).map(|l| l.operations.len()).sum();
    let xml = job.xml().unwrap();
    assert!(xml.contains("<name>shell &lt;1&gt; &amp; &quot;2&quot;</name>"), "{xml}");
    assert_eq!(xml.matches("<operation>").count(), operations);
    assert_eq!(xml.matches("<electrode>").count(), job.electrodes.len());
    let csv = job.csv();
    let mut lines = csv.lines();
    let columns = lines.next().unwrap().split(',').count();
    assert_eq!(lines.clone().count(), operations);
    // The name of the material holds a comma.
    let is_whole =
        |line: &str| line.matches("\"Cu, \"\"soft\"\"\"").count() == 1 && line.split(',').count() == columns + 1;
    assert!(lines.all(is_whole), "{csv}");
}
