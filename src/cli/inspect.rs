//! `sparkpath inspect`: what the importer and the channel finder make of a mesh.

use super::{Answer, InspectArguments, Session};
use crate::workspaces::blisk::job::measured::at_channel;
use crate::workspaces::blisk::job::stages::{BliskMesh, read_blisk};
use crate::workspaces::blisk::report::InputFile;
use files::report::counted;
use geometry::exact::ExactMesh;
use geometry::mesh::Mesh;
use import::ImportReport;
use wheel::centreline::CentrelineSummary;
use wheel::inspect::{ChannelSummary, inspect as inspect_blisk};
use wheel::nurbs_wall::NurbsWall;
use wheel::section_deviation::SectionsDeviation;
use wheel::sections::{MeasuredSection, read_sections_file};

/// Prints what was found in the mesh of `arguments`.
pub(super) fn inspect(arguments: &InspectArguments, session: &Session) -> anyhow::Result<Answer> {
    let job = super::plan::read(&arguments.project, session)?;
    let read = read_blisk(&job, &session.task).map_err(anyhow::Error::msg)?;
    let Some(BliskMesh { mesh, file: InputFile { path: file, sha256, .. }, report, sections, faces, .. }) = read else {
        anyhow::bail!(
            "{}: blisk.mesh is missing; give a mesh, or blades in blisk.sections",
            arguments.project.file.display()
        )
    };
    let inspection = inspect_blisk(&mesh, faces.as_ref(), &job.blisk.options, &session.task)?;
    let measured = match (&inspection.channel, inspection.walls.as_deref(), inspection.repetition) {
        (Some(channel), Some(walls), Some(repetition)) => {
            let wheel = inspection.whole.as_deref().unwrap_or(&mesh).in_frame(&channel.frame);
            let (sections, limit) = match &arguments.sections {
                Some(file) => (read_sections_file(file).map_err(|e| anyhow::anyhow!("{}: {e}", file.display()))?, None),
                // Those that the wheel itself was made from.
                None => {
                    let own = at_channel(&sections, &channel.frame, repetition.blades);
                    (own, Some(job.blisk.sections.limit_mm()))
                }
            };
            let made = |limit: f64| Measured::new(&sections, (channel, walls, &wheel), limit, session);
            match limit {
                _ if sections.is_empty() => None,
                None => Some(made(arguments.limit)?),
                Some(limit) => {
                    let others = SectionsDeviation::of_each(&sections, limit, &session.task.cancel)?;
                    Some(Measured { others: Some(others), ..made(limit)? })
                }
            }
        }
        _ => None,
    };
    super::terminal::finish();
    if session.json {
        let mut all = serde_json::json!({ "sha256": sha256, "import": report, "blisk": inspection });
        if let Some(Measured { surfaces, deviation, others }) = &measured {
            all["measured"] = serde_json::to_value(surfaces)?;
            all["measured"]["deviation"] = serde_json::to_value(deviation)?;
            all["measured"]["from_others"] = serde_json::to_value(others)?;
            all["measured"]["within_limit"] = measured.as_ref().is_some_and(Measured::holds).into();
        }
        say!("{}", serde_json::to_string_pretty(&all)?);
    } else {
        // The verdict comes first.
        say!("{inspection}");
        if let Some(Measured { surfaces, deviation, others }) = &measured {
            say!("From the measured sections:\n{deviation}{surfaces}");
            if let Some(others) = others {
                say!("Each section against the wall through the others:\n{others}");
            }
        }
        report.iter().for_each(print_import);
    }
    match inspection.not_found.first() {
        None if measured.is_some_and(|m| !m.holds()) => Ok(Answer::No),
        None => Ok(Answer::Yes),
        Some(problem) if session.json => anyhow::bail!("{file}: {problem}"),
        Some(_) => anyhow::bail!("{file}: refused, for the reason in its verdict"),
    }
}

/// What measured sections tell.
struct Measured {
    /// The surfaces through them, against the mesh.
    surfaces: CentrelineSummary,
    /// Deviations of the measured points from the walls of the channel.
    deviation: SectionsDeviation,
    /// Each section against walls through the others, where the wheel was made from them.
    others: Option<SectionsDeviation>,
}

impl Measured {
    /// `sections` judged against `limit` (mm); they, channel, walls and mesh are in W.
    fn new(
        sections: &[MeasuredSection],
        (channel, walls, mesh): (&ChannelSummary, &[NurbsWall; 2], &Mesh),
        limit: f64,
        session: &Session,
    ) -> anyhow::Result<Self> {
        let cancel = &session.task.cancel;
        let wrong = |problem: &dyn std::fmt::Display| anyhow::anyhow!("measured sections: {problem}");
        let deviation = SectionsDeviation::new(sections, walls, limit, cancel)?;
        let through = NurbsWall::of_measured(sections, cancel).map_err(|e| wrong(&e))?;
        let exact = ExactMesh::new(mesh)?;
        let surfaces = CentrelineSummary::of_walls(&through, channel.sides, &exact, cancel);
        Ok(Self { surfaces: surfaces.map_err(|e| wrong(&e))?, deviation, others: None })
    }

    /// Whether every verdict is good.
    fn holds(&self) -> bool {
        self.deviation.holds() && self.others.as_ref().is_none_or(|others| others.sections.is_empty() || others.holds())
    }
}

fn print_import(r: &ImportReport) {
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
    for solid in &r.solids {
        let taken = match (solid.is_taken, solid.is_obstacle) {
            (true, _) => "",
            (_, true) => ", obstacle",
            _ => ", left out",
        };
        let closed = if solid.is_closed { "closed" } else { "open" };
        let (number, name, volume) = (solid.number, &solid.name, solid.volume_mm3);
        say!("solid {number:<6} {name}: {}, {volume:.5} mm3, {closed}{taken}", counted(solid.faces, "face"));
    }
    if let Some(tolerance) = r.step_tolerance_mm {
        say!("tolerance    triangles within {tolerance} mm of the exact faces (step_tolerance_mm)");
    }
    for warning in &r.warnings {
        say!("note         {warning}");
    }
}
