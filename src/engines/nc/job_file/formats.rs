//! A job file as JSON, XML and CSV.

use std::fmt::Write;

use files::report::{escape, quoted};
use serde_json::Value;

use super::JobFile;

impl JobFile {
    /// The job as JSON.
    ///
    /// # Errors
    /// The writer's own; none is known.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The job as XML: an element for each key, in alphabetical order; of a list one for each item, under the name of the
    /// list without its s; numbers of a list in one element, with spaces between.
    ///
    /// # Errors
    /// Every error of [`json`](Self::json).
    pub fn xml(&self) -> Result<String, serde_json::Error> {
        let mut xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned();
        element(&mut xml, 0, "job", &serde_json::to_value(self)?);
        Ok(xml)
    }

    /// The job as CSV: one row for each operation, with what it belongs to.
    pub fn csv(&self) -> String {
        let mut csv =
            "workpiece,electrode,name,stage,material,spark_gap_mm,location,channel,x_mm,y_mm,z_mm,a_deg,b_deg,\
                       c_deg,depth_mm,retract_mm,operation,kind,path,certified_clearance_mm,volume_mm3,minutes\n"
                .to_owned();
        let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        for electrode in &self.electrodes {
            for location in &electrode.locations {
                for operation in &location.operations {
                    let p = &location.position;
                    let kind = serde_json::to_value(operation.kind).unwrap_or_default();
                    let cells = [
                        self.workpiece.id.clone(),
                        electrode.id.clone(),
                        electrode.name.clone(),
                        electrode.stage.clone().unwrap_or_default(),
                        electrode.material.clone().unwrap_or_default(),
                        electrode.spark_gap_mm.to_string(),
                        location.id.clone(),
                        location.channel.map(|n| n.to_string()).unwrap_or_default(),
                        p.x_mm.to_string(),
                        p.y_mm.to_string(),
                        p.z_mm.to_string(),
                        number(p.a_deg),
                        number(p.b_deg),
                        p.c_deg.to_string(),
                        number(location.depth_mm),
                        number(location.retract_mm),
                        operation.id.clone(),
                        kind.as_str().unwrap_or_default().to_owned(),
                        operation.path.as_ref().map(|file| file.name.clone()).unwrap_or_default(),
                        number(operation.certified_clearance_mm),
                        number(operation.volume_mm3),
                        number(operation.minutes),
                    ];
                    csv += &(cells.map(|cell| quoted(&cell)).join(",") + "\n");
                }
            }
        }
        csv
    }
}

/// Adds `value` as an element; nothing where it is null.
fn element(xml: &mut String, depth: usize, name: &str, value: &Value) {
    let indent = "  ".repeat(depth);
    // Writing into a string does not fail.
    let _ = match value {
        Value::Null => Ok(()),
        Value::Array(list) => {
            let numbers = numbers(value).filter(|numbers| !numbers.is_empty());
            if let Some(numbers) = numbers {
                writeln!(xml, "{indent}<{name}>{}</{name}>", numbers.join(" "))
            } else {
                list.iter().for_each(|item| element(xml, depth, name.strip_suffix('s').unwrap_or(name), item));
                Ok(())
            }
        }
        Value::Object(keys) => {
            let _ = writeln!(xml, "{indent}<{name}>");
            keys.iter().for_each(|(key, value)| element(xml, depth + 1, key, value));
            writeln!(xml, "{indent}</{name}>")
        }
        Value::String(text) => writeln!(xml, "{indent}<{name}>{}</{name}>", escape(text)),
        other => writeln!(xml, "{indent}<{name}>{other}</{name}>"),
    };
}

/// The numbers of a list, and of lists in it, in their order; none if it holds something else.
fn numbers(value: &Value) -> Option<Vec<String>> {
    match value {
        Value::Number(number) => Some(vec![number.to_string()]),
        Value::Array(list) => list.iter().map(numbers).collect::<Option<Vec<_>>>().map(|all| all.concat()),
        _ => None,
    }
}
