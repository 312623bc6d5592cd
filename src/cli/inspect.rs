//! `sparkpath inspect`: what the importer and the channel finder make of a mesh.

use super::{Answer, InspectArguments, Session};
use crate::blisk::inspect::inspect as inspect_blisk;
use crate::blisk::options::{Auto, AxisChoice, BliskOptions};
use crate::mesh_io::Imported;

/// Prints what was found in the mesh of `arguments`.
pub(super) fn inspect(arguments: &InspectArguments, session: &Session) -> anyhow::Result<Answer> {
    let options = options(arguments)?;
    let imported = session.import(&arguments.mesh, arguments.units)?;
    options.validate().map_err(anyhow::Error::msg)?;
    let inspection = inspect_blisk(&imported.mesh, &options, &session.progress, &session.cancel)?;
    super::terminal::finish();
    if session.json {
        let all = serde_json::json!({ "sha256": imported.sha256, "import": imported.report, "blisk": inspection });
        say!("{}", serde_json::to_string_pretty(&all)?);
    } else {
        print_import(&imported);
        say!("{inspection}");
    }
    match inspection.not_found.first() {
        None => Ok(Answer::Yes),
        Some(problem) => anyhow::bail!("{}: {problem}", arguments.mesh.display()),
    }
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
