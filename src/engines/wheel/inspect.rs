//! Results of the channel finder for a mesh, as a table for a reader and as data for a report.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use serde::Serialize;

use super::cad_faces::TurnedFaces;
use super::centreline::{CentrelineError, CentrelineSummary};
use super::channel::{Agreement, BladeSide, Channel, Flow, Station, Throat};
use super::error::BliskError;
use super::find_channel::{prepared, wheel_and_channel};
use super::frame::{Axis, Repetition, Wheel};
use super::nurbs_wall::NurbsWall;
use super::options::BliskOptions;
use super::surfaces::{SurfaceClass, SurfaceClasses, classify};
use geometry::frame::Frame;
use geometry::mesh::Mesh;
use geometry::nurbs::FitError;
use geometry::segmentation::CadFaces;
use task::{Cancelled, Task};

/// Everything found in a mesh. What comes after the first thing not found is absent.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// Number of triangles.
    pub triangles: usize,
    /// Extent along the mesh's own axes (mm).
    pub size_mm: DVec3,
    /// Whether the mesh is closed.
    pub watertight: bool,
    /// Enclosed volume (mm^3).
    pub volume_mm3: f64,
    /// The blisk's axis in the coordinates of the mesh.
    pub axis: Option<Axis>,
    /// The blade count and how exactly the blades repeat.
    pub repetition: Option<Repetition>,
    /// The chosen channel.
    pub channel: Option<ChannelSummary>,
    /// The whole wheel in the coordinates of the mesh, where that is only a sector of it; written as its volume.
    #[serde(rename = "whole_wheel_volume_mm3", serialize_with = "as_volume")]
    pub whole: Option<Arc<Mesh>>,
    /// The faces of the CAD program that are turned about the axis, where the file of the part has faces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turned_faces: Option<TurnedFaces>,
    /// Surfaces of the mesh told apart.
    pub surfaces: Option<SurfaceClasses>,
    /// Centreline of the channel, and figures of its walls as NURBS.
    pub centreline: Option<CentrelineSummary>,
    /// The low and the high wall of the channel as NURBS, in W.
    #[serde(skip)]
    pub walls: Option<Arc<[NurbsWall; 2]>>,
    /// Assumptions made, in plain sentences.
    pub assumed: Vec<String>,
    /// Missing features, with reason and remedy.
    pub not_found: Vec<String>,
}

/// Writes the volume of a mesh (mm^3), if there is one.
fn as_volume<S: serde::Serializer>(mesh: &Option<Arc<Mesh>>, to: S) -> Result<S::Ok, S::Error> {
    mesh.as_ref().map(|mesh| mesh.volume()).serialize(to)
}

/// The figures of a channel, without its walls' points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelSummary {
    /// Number of the channel.
    pub index: usize,
    /// W in the coordinates of the mesh (mm).
    pub frame: Frame,
    /// Direction of the passage.
    pub flow: Flow,
    /// Whether there is a shroud; if not, its radii are those of the blade tips.
    pub shrouded: bool,
    /// Hub and shroud at some positions along the passage.
    pub meridian: Vec<Station>,
    /// Grid points of a wall along the chord and from hub to shroud.
    pub wall_grid: [usize; 2],
    /// Faces of their blades that the low and the high wall are.
    pub sides: [BladeSide; 2],
    /// X between the blades' edges (mm).
    pub span_x_mm: [f64; 2],
    /// X of the blisk's two faces (mm).
    pub faces_x_mm: [f64; 2],
    /// The narrowest place between the walls.
    pub throat: Throat,
    /// Turn of the middle line (deg).
    pub turning_deg: f64,
    /// How well the surfaces agree with the mesh.
    pub agreement: Vec<Agreement>,
    /// Number of kinds of channels.
    pub kinds: usize,
    /// Channels of its kind that are not like it.
    pub unlike: Vec<usize>,
}

impl ChannelSummary {
    /// The figures of `channel`, its meridian thinned to about a dozen samples.
    pub fn new(channel: &Channel) -> Self {
        const ROWS: usize = 12;
        let last = channel.meridian.len().saturating_sub(1);
        let rows = ROWS.min(last);
        let meridian = (0..=rows).filter_map(|i| channel.meridian.get(i * last / rows.max(1)).copied()).collect();
        Self {
            index: channel.index,
            frame: channel.frame,
            flow: channel.flow,
            shrouded: channel.shrouded,
            meridian,
            wall_grid: [channel.low.nu, channel.low.nv],
            sides: [channel.low.side, channel.high.side],
            span_x_mm: channel.span_x(),
            faces_x_mm: channel.faces_x,
            throat: channel.throat,
            turning_deg: channel.turning.to_degrees(),
            agreement: channel.agreement.clone(),
            kinds: channel.kinds,
            unlike: channel.unlike.iter().map(|unlike| unlike.number).collect(),
        }
    }
}

/// Finds what can be found in `mesh` (mm), whose file may have `faces`; what cannot is listed in
/// [`Inspection::not_found`].
///
/// # Errors
/// Only when cancelled.
pub fn inspect(
    mesh: &Mesh,
    faces: Option<&CadFaces>,
    options: &BliskOptions,
    task: &Task,
) -> Result<Inspection, Cancelled> {
    let mut found = Inspection {
        triangles: mesh.triangles.len(),
        size_mm: if mesh.vertices.is_empty() { DVec3::ZERO } else { mesh.bounds().size() },
        watertight: false,
        volume_mm3: 0.0,
        axis: None,
        repetition: None,
        channel: None,
        whole: None,
        turned_faces: None,
        surfaces: None,
        centreline: None,
        walls: None,
        assumed: Vec::new(),
        not_found: Vec::new(),
    };
    match fill(&mut found, mesh, faces, options, task) {
        Err(BliskError::Cancelled(cancelled)) => return Err(cancelled),
        Err(error) => {
            found.axis = found.axis.or(error.axis());
            found.not_found.push(error.to_string());
        }
        Ok(()) => {}
    }
    Ok(found)
}

fn fill(
    found: &mut Inspection,
    mesh: &Mesh,
    faces: Option<&CadFaces>,
    options: &BliskOptions,
    task: &Task,
) -> Result<(), BliskError> {
    let (mesh, assumed) = prepared(mesh, options)?;
    found.assumed = assumed;
    found.watertight = mesh.is_watertight();
    found.volume_mm3 = mesh.volume();
    let assumed = found.assumed.clone();
    let mut tell = |wheel: &Wheel| {
        found.axis = Some(wheel.blisk.axis);
        found.repetition = Some(wheel.blisk.repetition);
        found.assumed = [&assumed[..], &wheel.blisk.assumed].concat();
    };
    let (wheel, channel) =
        wheel_and_channel(&mesh, options, &assumed, task, &mut tell).map_err(|refused| refused.error)?;
    found.channel = Some(ChannelSummary::new(&channel));
    found.whole = channel.whole.clone();
    found.assumed = channel.assumed.clone();
    found.turned_faces = faces.map(|faces| TurnedFaces::new(&mesh, faces, &wheel.blisk.axis));
    found.surfaces = Some(classify(&mesh, &channel, faces.map_or(&[], |faces| &faces.face_of), task)?);
    task.report("channel", 1.0, "centreline");
    found.walls = NurbsWall::of_channel(&channel).ok().map(Arc::new);
    let exact =
        channel.exact(&wheel.mesh.in_frame(&channel.frame).into()).map_err(|e| BliskError::Mesh(e.to_string()))?;
    match CentrelineSummary::new(&channel, &exact, &task.cancel) {
        Ok(line) => found.centreline = Some(line),
        Err(CentrelineError::Cancelled(cancelled)) => return Err(cancelled.into()),
        // Only one of the strategies needs it.
        Err(error) => found.assumed.push(format!("No centreline: {error}.")),
    }
    Ok(())
}

impl Inspection {
    /// The verdict in a sentence: what was found agrees with the mesh, or why it was refused.
    pub fn verdict(&self) -> String {
        let Some(channel) = &self.channel else {
            return format!("refused: {}", self.not_found.join("; "));
        };
        let of = |a: &Agreement| format!("{} {:.1} %", a.surface.name(), 100.0 * a.share);
        let surfaces: Vec<String> = channel.agreement.iter().map(of).collect();
        let unlike = match channel.unlike.len() {
            0 => String::new(),
            count => format!("; other channels that are not like it: {count}"),
        };
        let within = channel.agreement.iter().map(|a| a.within_mm).fold(0.0, f64::max);
        let open = if self.watertight { "" } else { "; the mesh is not closed, so that nothing can be planned in it" };
        format!(
            "agrees with the mesh, within {within:.3} mm and its chord error: {}{unlike}{open}",
            surfaces.join(", ")
        )
    }
}

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut row = |name: &str, value: String| writeln!(f, "{name:<18}{value}");
        row("Verdict", self.verdict())?;
        let s = self.size_mm;
        row("Mesh", format!("{} triangles, {:.3} x {:.3} x {:.3} mm", self.triangles, s.x, s.y, s.z))?;
        row(
            "",
            format!("{}, volume {:.1} mm³", if self.watertight { "closed" } else { "not closed" }, self.volume_mm3),
        )?;
        if let Some(whole) = &self.whole {
            row("Whole wheel", format!("{} triangles, volume {:.1} mm³", whole.triangles.len(), whole.volume()))?;
        }
        if let Some(axis) = &self.axis {
            row("Axis", axis.to_string())?;
        }
        if let Some(TurnedFaces { faces, turned, apart_mm }) = self.turned_faces {
            row("CAD faces", format!("{turned} of {faces} are turned about it, within {apart_mm:.6} mm"))?;
        }
        if let Some(r) = &self.repetition {
            let (blades, kinds) = (r.blades, r.kinds);
            let is_repeating = kinds < blades;
            let groups = match kinds {
                0 | 1 => blades.to_string(),
                _ if is_repeating => format!("{blades} in {} equal groups of {kinds}", blades / kinds),
                _ => format!("{blades}, none repeats another"),
            };
            row("Blades", groups)?;
            if is_repeating {
                row(
                    "",
                    format!(
                        "{:.1} % of {} wall points repeat within {:.3} mm; RMS {:.6} mm, greatest {:.6} mm",
                        100.0 * r.matched,
                        r.points,
                        r.tolerance_mm,
                        r.rms_mm,
                        r.greatest_mm
                    ),
                )?;
            }
        }
        if let Some(channel) = &self.channel {
            write!(f, "{channel}")?;
        }
        if let Some(surfaces) = &self.surfaces {
            write!(f, "{surfaces}")?;
        }
        if let Some(line) = &self.centreline {
            write!(f, "{line}")?;
        }
        list(f, "Assumed", &self.assumed)
    }
}

fn list(f: &mut fmt::Formatter<'_>, name: &str, sentences: &[String]) -> fmt::Result {
    for (i, sentence) in sentences.iter().enumerate() {
        writeln!(f, "{:<18}{sentence}", if i == 0 { name } else { "" })?;
    }
    Ok(())
}

impl fmt::Display for ChannelSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut row = |name: &str, value: String| writeln!(f, "{name:<18}{value}");
        let outer = if self.shrouded { "shroud" } else { "tips" };
        let [x0, x1] = self.span_x_mm;
        let [f0, f1] = self.faces_x_mm;
        let [nu, nv] = self.wall_grid;
        let [low, high] = self.sides;
        let shroud = if self.shrouded { "shrouded" } else { "without shroud" };
        row("Channel", format!("{}, {}, {shroud}", self.index, self.flow.name()))?;
        row("Blades from x", format!("{x0:.3} to {x1:.3} mm"))?;
        row("Faces at x", format!("{f0:.3} and {f1:.3} mm"))?;
        row("Walls", format!("{nu} x {nv} points; low {}, high {}", side_name(low), side_name(high)))?;
        row("Turning", format!("{:.2}°", self.turning_deg))?;
        row("Throat", format!("{:.3} mm", self.throat.width_mm))?;
        if self.flow == Flow::Axial {
            row("Radii", format!("{:>10}{:>10}{outer:>10}   mm", "x", "hub"))?;
            for s in &self.meridian {
                row("", format!("{:>10.3}{:>10.3}{:>10.3}", s.along, s.hub.y, s.shroud.y))?;
            }
            return Ok(());
        }
        row("Places", format!("{:>10}{:>20}{:>20}   mm", "along", "hub x, r", format!("{outer} x, r")))?;
        for s in &self.meridian {
            let [h, o] = [s.hub, s.shroud];
            row("", format!("{:>10.3}{:>10.3}{:>10.3}{:>10.3}{:>10.3}", s.along, h.x, h.y, o.x, o.y))?;
        }
        Ok(())
    }
}

impl fmt::Display for SurfaceClasses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut row = |name: &str, value: String| writeln!(f, "{name:<18}{value}");
        for (i, area) in self.areas.iter().enumerate() {
            let name = if i == 0 { "Surfaces" } else { "" };
            row(name, format!("{:<40}{:>12.1} mm²{:>10} triangles", area.name, area.area_mm2, area.triangles))?;
        }
        let radius = |r: Option<f64>| r.map_or("none, or of several radii".to_owned(), |r| format!("R {r:.3} mm"));
        let hub = format!("hub {}", radius(self.hub_fillet_mm));
        let is_shrouded = self.areas.iter().any(|area| area.class == SurfaceClass::Shroud);
        let shroud = format!(", shroud {}", radius(self.shroud_fillet_mm));
        row("Fillets", if is_shrouded { hub + &shroud } else { hub })
    }
}

impl fmt::Display for CentrelineSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut row = |name: &str, value: String| writeln!(f, "{name:<18}{value}");
        let error = |e: &FitError| format!("greatest {:.6} mm, RMS {:.6} mm", e.greatest_mm, e.rms_mm);
        let (made_of, middles) = match self.diameters_mm {
            Some([least, greatest]) => (
                format!("circles of {least:.3} to {greatest:.3} mm in {} sections", self.sections),
                "the sections' middles",
            ),
            None => (
                "half way between the walls: circles between them do not fit or leave its middle".to_owned(),
                "the middles",
            ),
        };
        row("Centreline", format!("{:.3} mm long, {made_of}", self.length_mm))?;
        row("", format!("off {middles}: {}", error(&self.fit)))?;
        for (name, wall) in ["low", "high"].iter().zip(&self.walls) {
            row("NURBS walls", format!("{name}, {}: off its points {}", side_name(wall.side), error(&wall.points)))?;
            row("", format!("off the mesh {}", error(&wall.mesh)))?;
        }
        Ok(())
    }
}

fn side_name(side: BladeSide) -> &'static str {
    match side {
        BladeSide::Suction => "suction",
        BladeSide::Pressure => "pressure",
        BladeSide::Flat => "flat",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{TestBlisk, flange};
    use task::Cancel;

    #[test]
    fn a_blisk_is_told_in_figures_and_a_flange_in_words() {
        let look = |mesh| inspect(&mesh, None, &BliskOptions::default(), &Task::default()).unwrap();
        let part = TestBlisk::default();
        let found = look(part.mesh());
        assert!(found.watertight && found.not_found.is_empty(), "{found}");
        assert_eq!(found.repetition.unwrap().blades, part.blades);
        let channel = found.channel.as_ref().unwrap();
        assert!((channel.faces_x_mm[1] - channel.faces_x_mm[0] - 20.0).abs() < 1e-9);
        let text = found.to_string();
        for word in ["Blades            24", "Throat", "shroud", "Assumed", "suction", "pressure"] {
            assert!(text.contains(word), "{word} in\n{text}");
        }
        assert!(serde_json::to_string(&found).unwrap().contains("\"turning_deg\""));

        let refused = look(flange(20.0, 60.0, 8, 6.0));
        assert!(refused.channel.is_none() && refused.axis.is_some());
        assert!(refused.to_string().contains("round holes"), "{refused}");
    }

    #[test]
    fn work_stops_when_told_to() {
        let cancel = Cancel::default();
        cancel.cancel();
        let found = inspect(&TestBlisk::default().mesh(), None, &BliskOptions::default(), &Task::silent(&cancel));
        assert_eq!(found, Err(Cancelled));
    }
}
