//! `sparkpath inspect`: what the importer and the channel finder make of a mesh.

use std::path::Path;

use super::{Answer, InspectArguments, Session};
use crate::workspaces::blisk::document::job_file::BliskSection;
use files::report::counted;
use geometry::exact::ExactMesh;
use geometry::mesh::Mesh;
use import::Imported;
use wheel::centreline::CentrelineSummary;
use wheel::channel::BladeSide;
use wheel::inspect::inspect as inspect_blisk;
use wheel::nurbs_wall::NurbsWall;
use wheel::sections::read_sections_file;

/// Prints what was found in the mesh of `arguments`.
pub(super) fn inspect(arguments: &InspectArguments, session: &Session) -> anyhow::Result<Answer> {
    let BliskSection { mesh, units, options } = super::plan::read(&arguments.project, session)?.blisk;
    let Some(file) = mesh else {
        anyhow::bail!("{}: blisk.mesh is missing; give a mesh", arguments.project.file.display())
    };
    let imported = session.import_silently(&file, units)?;
    let inspection = inspect_blisk(&imported.mesh, &options, &session.task)?;
    let measured = match (&arguments.sections, &inspection.channel) {
        (Some(file), Some(channel)) => {
            let wheel = inspection.whole.as_deref().unwrap_or(&imported.mesh);
            Some(measured(file, &wheel.in_frame(&channel.frame), channel.sides, session)?)
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
        Some(problem) if session.json => anyhow::bail!("{}: {problem}", file.display()),
        Some(_) => anyhow::bail!("{}: refused, for the reason in its verdict", file.display()),
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

fn print_import(imported: &Imported) {
    let r = &imported.report;
    say!(
        "file         {}, {} triangles read, {} kept, {} vertices",
        r.format.name(),
        r.triangles_read,
        r.triangles,
        r.vertices
    );
    // The reason of a guess is among the notes.
    say!("unit         {}", if r.unit_certain { &r.unit_reason } else { r.unit.name() });
    say!(
        "surface      {}, {}, {}, {}",
        if r.watertight { "watertight" } else { "open" },
        counted(r.components, "part"),
        counted(r.hole_count, "hole"),
        counted(r.non_manifold_edges, "non-manifold edge")
    );
    for warning in &r.warnings {
        say!("note         {warning}");
    }
}
