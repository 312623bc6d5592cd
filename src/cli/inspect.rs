//! `sparkpath inspect`: what the importer and the channel finder make of a mesh.

use std::path::Path;

use super::{Answer, InspectArguments, Session};
use geometry::exact::ExactMesh;
use geometry::mesh::Mesh;
use import::Imported;
use wheel::centreline::CentrelineSummary;
use wheel::channel::BladeSide;
use wheel::inspect::inspect as inspect_blisk;
use wheel::nurbs_wall::NurbsWall;
use wheel::options::{Auto, AxisChoice, BliskOptions};
use wheel::sections::read_sections_file;

/// Prints what was found in the mesh of `arguments`.
pub(super) fn inspect(arguments: &InspectArguments, session: &Session) -> anyhow::Result<Answer> {
    let options = options(arguments)?;
    let imported = session.import(&arguments.mesh, arguments.units)?;
    options.validate().map_err(|e| anyhow::anyhow!(as_arguments(&e)))?;
    let found = inspect_blisk(&imported.mesh, &options, &session.task);
    let mut inspection = found.map_err(|e| anyhow::anyhow!(as_arguments(&e.to_string())))?;
    inspection.not_found.iter_mut().for_each(|problem| *problem = as_arguments(problem));
    let measured = match (&arguments.sections, &inspection.channel) {
        (Some(file), Some(channel)) => {
            Some(measured(file, &imported.mesh.in_frame(&channel.frame), channel.sides, session)?)
        }
        _ => None,
    };
    super::terminal::finish();
    if session.json {
        let mut all = serde_json::json!({ "sha256": imported.sha256, "import": imported.report, "blisk": inspection });
        if let Some(measured) = measured {
            all["measured"] = serde_json::to_value(measured)?;
        }
        say!("{}", serde_json::to_string_pretty(&all)?);
    } else {
        print_import(&imported);
        say!("{inspection}");
        if let Some(measured) = measured {
            say!("From the measured sections:\n{measured}");
        }
    }
    match inspection.not_found.first() {
        None => Ok(Answer::Yes),
        Some(problem) => anyhow::bail!("{}: {problem}", arguments.mesh.display()),
    }
}

/// The walls through the measured sections in `file`, against `mesh`, both in W.
fn measured(file: &Path, mesh: &Mesh, sides: [BladeSide; 2], session: &Session) -> anyhow::Result<CentrelineSummary> {
    let name = file.display();
    let sections = read_sections_file(file).map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
    let walls = NurbsWall::of_measured(&sections, &session.task.cancel).map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
    let exact = ExactMesh::new(mesh)?;
    CentrelineSummary::of_walls(&walls, sides, &exact, &session.task.cancel).map_err(|e| anyhow::anyhow!("{name}: {e}"))
}

/// `message` with the arguments of this command in place of the keys of a job file, which is not at hand here.
fn as_arguments(message: &str) -> String {
    const ARGUMENTS: [(&str, &str); 8] = [
        ("the keys [blisk] ", ""),
        ("the key [blisk] ", ""),
        ("[blisk] ", ""),
        ("hub_radius_mm", "--hub-radius"),
        ("shroud_radius_mm", "--shroud-radius"),
        ("with axis", "with --axis"),
        ("with blades", "with --blades"),
        ("channel is", "--channel is"),
    ];
    let mut text = message.to_owned();
    for key in ["axis", "blades"] {
        text = text.replace(&format!("[blisk] {key}:"), &format!("--{key}:"));
    }
    // Only what was a key becomes an argument: a message that names none stays as it is.
    if text.contains("[blisk] ") {
        ARGUMENTS.iter().for_each(|(key, argument)| text = text.replace(key, argument));
    }
    text
}

fn print_import(imported: &Imported) {
    let r = &imported.report;
    say!(
        "file         {:?}, {} triangles read, {} kept, {} vertices",
        r.format,
        r.triangles_read,
        r.triangles,
        r.vertices
    );
    say!("unit         {}: {}", r.unit.name(), r.unit_reason);
    say!(
        "surface      {}, {} parts, {} holes, {} non-manifold edges",
        if r.watertight { "watertight" } else { "open" },
        r.components,
        r.hole_count,
        r.non_manifold_edges
    );
    for warning in &r.warnings {
        say!("note         {warning}");
    }
}

fn options(arguments: &InspectArguments) -> anyhow::Result<BliskOptions> {
    let auto = |value: Option<f64>| value.map_or(Auto::Auto, Auto::Given);
    Ok(BliskOptions {
        axis: axis(&arguments.axis)?,
        blades: arguments.blades.map_or(Auto::Auto, Auto::Given),
        channel: arguments.channel,
        hub_radius_mm: auto(arguments.hub_radius),
        shroud_radius_mm: auto(arguments.shroud_radius),
        ..Default::default()
    })
}

/// `auto`, `x`, `y`, `z`, or six numbers: direction and point.
fn axis(text: &str) -> anyhow::Result<AxisChoice> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse::<f64>()).collect();
    let value = match numbers.as_deref() {
        Ok([dx, dy, dz, px, py, pz]) => serde_json::json!({ "direction": [dx, dy, dz], "point": [px, py, pz] }),
        _ => serde_json::json!(text),
    };
    serde_json::from_value(value).map_err(|_| {
        anyhow::anyhow!("--axis {text}: expected auto, x, y, z, or six numbers dx,dy,dz,px,py,pz (direction and point)")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_a_job_file_become_arguments() {
        for (message, expected) in [
            (
                "give its axis with the key [blisk] axis and its blade count with [blisk] blades",
                "give its axis with --axis and its blade count with --blades",
            ),
            ("give its radius with the key [blisk] hub_radius_mm", "give its radius with --hub-radius"),
            ("check the keys [blisk] hub_radius_mm and shroud_radius_mm", "check --hub-radius and --shroud-radius"),
            ("[blisk] channel is 9, but the blisk has 4 channels", "--channel is 9, but the blisk has 4 channels"),
            ("[blisk] blades: must be \"auto\"", "--blades: must be \"auto\""),
            ("give the right axis with the key [blisk] axis", "give the right axis with --axis"),
            ("the axis through (0, 0, 0) has nothing", "the axis through (0, 0, 0) has nothing"),
        ] {
            assert_eq!(as_arguments(message), expected);
        }
    }
}
