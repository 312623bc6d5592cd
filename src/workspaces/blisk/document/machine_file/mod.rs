//! Machine files, from which a [`MachineModel`] and the keys of `[machine]` of a project are read.
//!
//! A machine is a URDF file (see `urdf.rs`) or a TOML file: axes, travels and speeds under the keys of `[machine]` of a
//! job, and a list of bodies.
//!
//! ```toml
//! axes = "XYZAC"
//! travel_x_mm = [-250.0, 250.0]
//!
//! [[bodies]]
//! name = "chuck"
//! carried_by = "electrode"
//! shape = "box"
//! size_mm = [30.0, 36.0, 36.0]
//! centre_mm = [15.0, 0.0, 0.0]
//! ```

#[cfg(test)]
mod tests;
mod urdf;

use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;

use feed::machine::MachineParams;
use feed::machine_model::{Body, Carrier, MachineModel};
use files::{FileError, Invalid, TomlFile, read_text};
use geometry::mesh::Mesh;
use import::{ImportError, ImportOptions, Units, import_file};
use task::{Cancelled, Task};
use urdf::{Look, UrdfBody};

/// Names of the built-in machines.
pub const BUILT_IN: [&str; 4] = ["xyzc", "xyzac", "xyzabc", "xyzac-ram"];
/// Sides of the prism that stands for a cylinder.
const SIDES: u32 = 96;
/// Greatest number of bodies of a machine.
const MOST_BODIES: usize = 64;
/// Greatest number of triangles of all bodies of a machine.
const MOST_TRIANGLES: usize = 500_000;
/// Greatest size and coordinate of a body (mm).
const LARGEST: f64 = 1e4;
/// The largest file that is read (bytes).
const LARGEST_FILE: u64 = 4 << 20;

/// Files of machines that are no URDF.
const MACHINE: TomlFile<toml::Table> = TomlFile::new("machine");

/// Reason why a machine cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum MachineFileError {
    /// The file cannot be read, or is no machine file.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is no built-in machine of that name.
    #[error(
        "name = {name:?}: there is no such machine; there are {}, and files that end in .toml or .urdf",
        BUILT_IN.join(", ")
    )]
    NoSuchMachine {
        /// The name.
        name: String,
    },
    /// A body is not possible.
    #[error("{file}: body {body}: {problem}")]
    Body {
        /// The file or the name of the machine.
        file: String,
        /// The body's name, or its number if it has none.
        body: String,
        /// What is wrong and what to do, in one line.
        problem: String,
    },
    /// The mesh of a body cannot be read.
    #[error("{file}: body {body}: {source}")]
    Mesh {
        /// The file or the name of the machine.
        file: String,
        /// The body's name.
        body: String,
        /// Reason that the import gives.
        source: Box<ImportError>,
    },
    /// The task was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A body as the file has it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyEntry {
    name: String,
    carried_by: Carrier,
    shape: ShapeName,
    size_mm: Option<[f64; 3]>,
    radius_mm: Option<f64>,
    length_mm: Option<f64>,
    axis: Option<AxisName>,
    centre_mm: Option<[f64; 3]>,
    file: Option<PathBuf>,
    units: Option<Units>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShapeName {
    Box,
    Cylinder,
    Mesh,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum AxisName {
    X,
    Y,
    Z,
}

/// Whether the machine `name` is a file rather than one of the built-in ones.
pub fn is_file(name: &str) -> bool {
    name.ends_with(".toml") || is_urdf(name)
}

fn is_urdf(name: &str) -> bool {
    name.ends_with(".urdf")
}

/// A machine's text, and the folder that paths in it are relative to.
fn text_of(name: &str) -> Result<(String, PathBuf), MachineFileError> {
    if !is_file(name) {
        let text = built_in_text(name);
        let text = text.ok_or_else(|| MachineFileError::NoSuchMachine { name: name.to_owned() })?;
        return Ok((text.to_owned(), PathBuf::new()));
    }
    let file = PathBuf::from(name);
    let text = read_text(&file, "machine", LARGEST_FILE)?;
    Ok((text, file.parent().map(Path::to_owned).unwrap_or_default()))
}

/// Axes, travels and speeds of the machine `name`, a built-in one or a file, under the keys of `[machine]` of a
/// project.
///
/// # Errors
/// [`MachineFileError`].
pub fn machine_table(name: &str) -> Result<toml::Table, MachineFileError> {
    let text = text_of(name)?.0;
    if is_urdf(name) {
        return urdf::table(&text).map_err(|e| invalid(name, &e));
    }
    let mut table = parse(name, &text)?;
    table.remove("bodies");
    if table.contains_key("name") {
        return Err(invalid(name, "a machine file has no key name; that is a key of a project"));
    }
    match toml::Value::Table(table.clone()).try_into::<MachineParams>() {
        Ok(_) => Ok(table),
        Err(error) => Err(invalid(name, &one_line(&error.to_string()))),
    }
}

/// The bodies of the machine `name`, a built-in one or a file.
///
/// # Errors
/// [`MachineFileError`].
pub fn read_machine(name: &str, task: &Task) -> Result<MachineModel, MachineFileError> {
    let (text, folder) = text_of(name)?;
    if is_urdf(name) {
        return read_urdf(name, &text, &folder, task);
    }
    let mut table = parse(name, &text)?;
    let bodies = match table.remove("bodies") {
        None => Vec::new(),
        Some(toml::Value::Array(bodies)) => bodies,
        Some(_) => return Err(invalid(name, "bodies must be a list; write [[bodies]] before each")),
    };
    if bodies.len() > MOST_BODIES {
        return Err(invalid(name, &format!("{} bodies are more than {MOST_BODIES}; join some", bodies.len())));
    }
    let mut model = MachineModel::default();
    for (i, value) in bodies.into_iter().enumerate() {
        let name_of = |value: &toml::Value| value.get("name").and_then(|n| n.as_str()).map(str::to_owned);
        let called = name_of(&value).unwrap_or_else(|| (i + 1).to_string());
        let wrong = |problem: String| MachineFileError::Body { file: name.to_owned(), body: called.clone(), problem };
        let entry: BodyEntry = value.try_into().map_err(|e: toml::de::Error| wrong(one_line(e.message())))?;
        if entry.name.trim().is_empty() || model.bodies.iter().any(|b| b.name == entry.name) {
            return Err(wrong("every body needs a name of its own".to_owned()));
        }
        let mesh = match entry.shape {
            ShapeName::Mesh => read_mesh(name, &folder, &entry, task)?,
            _ => primitive(&entry).map_err(wrong)?,
        };
        add(&mut model, Body { name: entry.name, carrier: entry.carried_by, mesh }).map_err(wrong)?;
    }
    Ok(model)
}

/// Adds a body, unless there are too many triangles then.
fn add(model: &mut MachineModel, body: Body) -> Result<(), String> {
    if ["electrode", "blisk"].contains(&body.name.as_str()) {
        return Err(format!("{} is what the part itself is called; name the body otherwise", body.name));
    }
    model.bodies.push(body);
    let triangles: usize = model.bodies.iter().map(|b| b.mesh.triangles.len()).sum();
    if triangles > MOST_TRIANGLES {
        return Err(format!(
            "with it the bodies have {triangles} triangles, more than {MOST_TRIANGLES}; give a coarser mesh"
        ));
    }
    Ok(())
}

fn read_urdf(name: &str, text: &str, folder: &Path, task: &Task) -> Result<MachineModel, MachineFileError> {
    let bodies = urdf::bodies(text, folder).map_err(|e| invalid(name, &e))?;
    if bodies.len() > MOST_BODIES {
        return Err(invalid(name, &format!("{} bodies are more than {MOST_BODIES}; join some", bodies.len())));
    }
    let mut model = MachineModel::default();
    for UrdfBody { name: called, carrier, look } in bodies {
        let wrong = |problem: String| MachineFileError::Body { file: name.to_owned(), body: called.clone(), problem };
        let mesh = match look {
            Look::Made(mesh) => mesh,
            // Its numbers are taken as they are; what brings metres to mm is a part of the placement.
            Look::File(file, placement) => {
                closed_mesh((name, &called), &file, Units::Mm, &|p| placement.transform_point3(p), task)?
            }
        };
        if mesh.vertices.iter().any(|p| p.is_nan() || p.abs().max_element() > LARGEST) {
            return Err(wrong(format!("a coordinate is beyond {LARGEST} mm; URDF has metres")));
        }
        if model.bodies.iter().any(|b| b.name == called) {
            return Err(wrong("every link needs a name of its own".to_owned()));
        }
        add(&mut model, Body { name: called.clone(), carrier, mesh }).map_err(wrong)?;
    }
    Ok(model)
}

fn parse(name: &str, text: &str) -> Result<toml::Table, MachineFileError> {
    Ok(MACHINE.parse(text, Path::new(name))?)
}

fn invalid(name: &str, problem: &str) -> MachineFileError {
    FileError::invalid(Path::new(name), Invalid::of("", problem)).into()
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Takes a key that a shape must have.
fn need<T>(value: Option<T>, key: &str, shape: &str) -> Result<T, String> {
    value.ok_or_else(|| format!("{key} is missing; a {shape} needs it"))
}

fn length(key: &str, value: f64) -> Result<f64, String> {
    if value > 0.0 && value <= LARGEST {
        Ok(value)
    } else {
        Err(format!("{key} is {value}; it must be greater than 0 and at most {LARGEST} mm"))
    }
}

fn centre_of(entry: &BodyEntry) -> Result<DVec3, String> {
    let centre = entry.centre_mm.unwrap_or_default();
    match centre.iter().find(|v| v.is_nan() || v.abs() > LARGEST) {
        None => Ok(DVec3::from_array(centre)),
        Some(v) => Err(format!("centre_mm holds {v}; coordinates must be from -{LARGEST} to {LARGEST} mm")),
    }
}

/// The mesh of a box or a cylinder.
fn primitive(entry: &BodyEntry) -> Result<Mesh, String> {
    if entry.file.is_some() || entry.units.is_some() {
        return Err("file and units belong to shape = \"mesh\"".to_owned());
    }
    let centre = centre_of(entry)?;
    if entry.shape == ShapeName::Box {
        if entry.radius_mm.is_some() || entry.length_mm.is_some() || entry.axis.is_some() {
            return Err("radius_mm, length_mm and axis belong to shape = \"cylinder\"".to_owned());
        }
        let size = need(entry.size_mm, "size_mm", "box")?;
        for value in size {
            length("size_mm", value)?;
        }
        return Ok(cuboid(DVec3::from_array(size), centre));
    }
    if entry.size_mm.is_some() {
        return Err("size_mm belongs to shape = \"box\"".to_owned());
    }
    let radius = length("radius_mm", need(entry.radius_mm, "radius_mm", "cylinder")?)?;
    let along = length("length_mm", need(entry.length_mm, "length_mm", "cylinder")?)?;
    Ok(cylinder(radius, along, need(entry.axis, "axis", "cylinder")? as usize, centre))
}

/// The mesh in `file`, its vertices at `place`, if it is closed.
fn closed_mesh(
    (machine, body): (&str, &str),
    file: &Path,
    units: Units,
    place: &dyn Fn(DVec3) -> DVec3,
    task: &Task,
) -> Result<Mesh, MachineFileError> {
    let (machine, body) = (machine.to_owned(), body.to_owned());
    let options = ImportOptions { reading: units.into(), ..Default::default() };
    let imported = match import_file(file, &options, task) {
        Ok(imported) => imported,
        Err(ImportError::Cancelled(cancelled)) => return Err(cancelled.into()),
        Err(source) => return Err(MachineFileError::Mesh { file: machine, body, source: source.into() }),
    };
    if !imported.mesh.is_watertight() {
        let problem = format!(
            "the surface of {} is not closed, so that it has no inside; close it in the program it came from",
            file.display()
        );
        return Err(MachineFileError::Body { file: machine, body, problem });
    }
    Ok(imported.mesh.mapped(place))
}

fn read_mesh(machine: &str, folder: &Path, entry: &BodyEntry, task: &Task) -> Result<Mesh, MachineFileError> {
    let wrong =
        |problem: String| MachineFileError::Body { file: machine.to_owned(), body: entry.name.clone(), problem };
    if entry.size_mm.is_some() || entry.radius_mm.is_some() || entry.length_mm.is_some() || entry.axis.is_some() {
        return Err(wrong("size_mm, radius_mm, length_mm and axis do not belong to shape = \"mesh\"".to_owned()));
    }
    let file = folder.join(need(entry.file.clone(), "file", "mesh").map_err(wrong)?);
    let centre = centre_of(entry).map_err(wrong)?;
    let units = entry.units.unwrap_or(Units::Mm);
    let mesh = closed_mesh((machine, &entry.name), &file, units, &|p| p + centre, task)?;
    match mesh.vertices.iter().any(|p| p.abs().max_element() > LARGEST) {
        false => Ok(mesh),
        true => Err(wrong(format!("a coordinate is beyond {LARGEST} mm; check the unit"))),
    }
}

/// The file of the built-in machine called `name`.
fn built_in_text(name: &str) -> Option<&'static str> {
    match name {
        "xyzc" => Some(include_str!("../../../../../assets/machines/xyzc.toml")),
        "xyzac" => Some(include_str!("../../../../../assets/machines/xyzac.toml")),
        "xyzabc" => Some(include_str!("../../../../../assets/machines/xyzabc.toml")),
        "xyzac-ram" => Some(include_str!("../../../../../assets/machines/xyzac-ram.toml")),
        _ => None,
    }
}

/// The box of this size about `centre` (mm).
fn cuboid(size: DVec3, centre: DVec3) -> Mesh {
    let least = centre - 0.5 * size;
    let mut mesh = Mesh::cuboid(size);
    mesh.vertices.iter_mut().for_each(|p| *p = least + *p);
    mesh
}

/// A prism about the cylinder with this radius and length (mm) about `centre`, its axis along coordinate `axis`. It
/// is circumscribed, so that no point of the cylinder is outside it; it is larger by 0.054 percent of the radius at
/// most.
fn cylinder(radius: f64, length: f64, axis: usize, centre: DVec3) -> Mesh {
    let outer = radius / (PI / f64::from(SIDES)).cos();
    let rim = |k: u32, along: f64| {
        let (sine, cosine) = (TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
        let mut p = DVec3::ZERO;
        (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (along, outer * cosine, outer * sine);
        centre + p
    };
    let ends = [-0.5 * length, 0.5 * length];
    let mut vertices: Vec<DVec3> =
        ends.iter().flat_map(|&along| (0..SIDES).map(move |k| (k, along))).map(|(k, a)| rim(k, a)).collect();
    for along in ends {
        let mut p = DVec3::ZERO;
        p[axis] = along;
        vertices.push(centre + p);
    }
    let (low, high) = (2 * SIDES, 2 * SIDES + 1);
    let side = |k: u32| {
        let next = (k + 1) % SIDES;
        let (far, far_next) = (k + SIDES, next + SIDES);
        [[k, next, far_next], [k, far_next, far], [low, next, k], [high, far, far_next]]
    };
    Mesh { vertices, triangles: (0..SIDES).flat_map(side).collect() }
}
