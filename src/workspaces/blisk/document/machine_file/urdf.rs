//! Machines as URDF files: links with collision geometry, joints between them.
//!
//! The joints that move are the machine's axes and are called after them: `x`, `y`, `z` prismatic, `a`, `b`, `c`
//! revolute or continuous, in either case, alone or at the end of a name (`joint_x`). All stand at zero in the final
//! pose. They go along and about the root's own axes, in the sense that the machine counts them: `+x`, `+y`, `+z`, `b`
//! about `+y`, `c` about `+z`, and `a`, which turns the table by `Rx(-a)`, about `-x`. An `<axis>` may be left out;
//! one that says otherwise is refused. What a link goes with follows from the joints between it and the root:
//!
//! | joints on the way to the link | goes with |
//! | --- | --- |
//! | `a` | the table |
//! | `b` or `c` | the electrode |
//! | `x`, `y` or `z` | the head |
//! | none | the bed |
//!
//! The root's frame is that of table and bed in a machine file, its origin on the blisk's axis at the blisk's face away
//! from the side of entry. The C axis goes through the origin of joint `c`, from which what the head carries is
//! counted; the electrode is held at the origin of the link `interface`, from which what turns with it is counted.
//! Lengths are metres and angles radians, as URDF has them.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use roxmltree::{Document, Node};

use feed::machine::AxisSet;
use feed::machine_model::Carrier;
use feed::pose::Axis;
use geometry::mesh::Mesh;

/// mm in a metre.
const MM: f64 = 1e3;
/// Links from the root to any other at most.
const DEEPEST: usize = 64;
/// How far the unit vectors of two directions that are taken for the same may be apart.
const SAME_DIRECTION: f64 = 1e-6;

/// What a body looks like.
pub(super) enum Look {
    /// A closed mesh in the coordinates of its carrier (mm).
    Made(Mesh),
    /// A mesh file, and what brings its coordinates, in metres, to those of the carrier (mm).
    File(PathBuf, DAffine3),
}

/// A body as the file has it.
pub(super) struct UrdfBody {
    pub name: String,
    pub carrier: Carrier,
    pub look: Look,
}

/// A joint with what it joins.
struct Joint<'a> {
    parent: &'a str,
    axis: Option<Axis>,
    origin: DAffine3,
    node: Node<'a, 'a>,
}

/// The joints of a file by the link that each carries.
struct Tree<'a> {
    joints: HashMap<&'a str, Joint<'a>>,
    links: Vec<Node<'a, 'a>>,
}

/// Where a link stands when all axes are at zero, in the root's frame (m), and the axes that move it.
struct Place {
    at: DAffine3,
    axes: Vec<Axis>,
}

fn read<T>(text: &str, with: impl FnOnce(&Tree) -> Result<T, String>) -> Result<T, String> {
    let document = Document::parse(text).map_err(|e| e.to_string())?;
    let robot = document.root_element();
    if robot.tag_name().name() != "robot" {
        return Err("the outermost element must be robot".to_owned());
    }
    let tree = Tree::new(robot)?;
    tree.check_joints()?;
    with(&tree)
}

/// Axes, travels and speeds under the keys of `[machine]` of a project.
pub(super) fn table(text: &str) -> Result<toml::Table, String> {
    read(text, |tree| {
        let axes = tree.axes()?;
        let mut table = toml::Table::new();
        table.insert("axes".to_owned(), format!("{axes:?}").into());
        let mut slowest = [f64::INFINITY; 2];
        for joint in tree.joints.values() {
            let (Some(axis), Some(limit)) = (joint.axis, child(joint.node, "limit")) else { continue };
            let rotary = axis.is_rotary();
            let scale = if rotary { 1f64.to_degrees() } else { MM };
            let letter = axis.letter().to_ascii_lowercase();
            if let (Some(lower), Some(upper)) = (number(limit, "lower")?, number(limit, "upper")?) {
                let key = format!("travel_{letter}_{}", if rotary { "deg" } else { "mm" });
                table.insert(key, toml::Value::Array(vec![(lower * scale).into(), (upper * scale).into()]));
            }
            if let Some(velocity) = number(limit, "velocity")?.filter(|v| *v > 0.0) {
                let slowest = &mut slowest[usize::from(rotary)];
                *slowest = slowest.min(velocity * scale * 60.0);
            }
        }
        for (key, speed) in ["speed_mm_min", "speed_deg_min"].into_iter().zip(slowest) {
            if speed.is_finite() {
                table.insert(key.to_owned(), speed.into());
            }
        }
        Ok(table)
    })
}

/// The bodies, paths of meshes relative to `folder`.
pub(super) fn bodies(text: &str, folder: &Path) -> Result<Vec<UrdfBody>, String> {
    read(text, |tree| {
        let mut bodies = Vec::new();
        for link in &tree.links {
            let name = attribute(*link, "name")?;
            let shapes: Vec<Node> = link.children().filter(|n| n.has_tag_name("collision")).collect();
            if shapes.is_empty() {
                continue;
            }
            let place = tree.place(name)?;
            let carrier = carrier(&place.axes).map_err(|e| format!("link {name}: {e}"))?;
            for (i, collision) in shapes.iter().enumerate() {
                let from = tree.counted_from(carrier).map_err(|e| format!("link {name}: {e}"))?;
                let at = place.at * origin(*collision)?;
                let to_carrier = DAffine3::from_mat3_translation(at.matrix3, (at.translation - from) * MM);
                let look = look(*collision, to_carrier, folder).map_err(|e| format!("link {name}: {e}"))?;
                let name = if shapes.len() > 1 { format!("{name} {}", i + 1) } else { name.to_owned() };
                bodies.push(UrdfBody { name, carrier, look });
            }
        }
        Ok(bodies)
    })
}

impl<'a> Tree<'a> {
    fn new(robot: Node<'a, 'a>) -> Result<Self, String> {
        let mut joints = HashMap::new();
        for node in robot.children().filter(|n| n.has_tag_name("joint")) {
            let name = attribute(node, "name")?;
            let wrong = |what: &str| format!("joint {name}: {what}");
            let linked = |tag| {
                let end = child(node, tag).ok_or_else(|| wrong(&format!("{tag} is missing")))?;
                attribute(end, "link").map_err(|e| wrong(&e))
            };
            let moves = attribute(node, "type")? != "fixed";
            let axis = moves.then(|| axis_of(name)).flatten();
            if moves && axis.is_none() {
                return Err(wrong("a joint that moves must be called after an axis: x, y, z, a, b or c"));
            }
            let joint = Joint { parent: linked("parent")?, axis, origin: origin(node)?, node };
            if joints.insert(linked("child")?, joint).is_some() {
                return Err(wrong("its child is carried by another joint too"));
            }
        }
        let links: Vec<Node> = robot.children().filter(|n| n.has_tag_name("link")).collect();
        let names = links.iter().map(|link| attribute(*link, "name")).collect::<Result<Vec<_>, _>>()?;
        if links.is_empty() {
            return Err("it has no link; give the machine's links and joints".to_owned());
        }
        let loose: Vec<&str> = names.into_iter().filter(|name| !joints.contains_key(name)).collect();
        match loose[..] {
            [_] => Ok(Self { joints, links }),
            [] => Err("every link is carried by a joint; one must be the root, carried by none".to_owned()),
            _ => Err(format!(
                "one link must be the root, carried by no joint; there are {}: {}",
                loose.len(),
                loose.join(", ")
            )),
        }
    }

    /// Makes sure that every joint that moves is of the right type and goes the way that the machine counts its axis.
    fn check_joints(&self) -> Result<(), String> {
        let mut joints: Vec<_> = self.joints.iter().collect();
        joints.sort_by_key(|(_, joint)| joint.node.id().get());
        for (link, joint) in joints {
            let Some(axis) = joint.axis else { continue };
            let wrong = |what: String| format!("joint {}: {what}", joint.node.attribute("name").unwrap_or_default());
            let (kind, fits) = match axis.is_rotary() {
                true => ("revolute or continuous", ["revolute", "continuous"]),
                false => ("prismatic", ["prismatic"; 2]),
            };
            let given = attribute(joint.node, "type")?;
            if !fits.contains(&given) {
                return Err(wrong(format!("its type is {given:?}; that of {} must be {kind}", axis.letter())));
            }
            let own = own_direction(axis);
            let along = child(joint.node, "axis").map_or(Ok(own), |n| vector(n, "xyz", DVec3::X)).map_err(&wrong)?;
            let is_turned = (self.place(link)?.at.matrix3 * along.normalize_or_zero()).distance(own) > SAME_DIRECTION;
            if is_turned {
                let [x, y, z] = own.to_array();
                return Err(wrong(format!(
                    "it must go along or about {x} {y} {z} of the root; turn its origin or its axis there"
                )));
            }
        }
        Ok(())
    }

    fn axes(&self) -> Result<AxisSet, String> {
        let has = |axis| self.joints.values().filter(|j| j.axis == Some(axis)).count();
        let counts = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::B, Axis::C].map(has);
        match counts {
            [1, 1, 1, 0, 0, 1] => Ok(AxisSet::XYZC),
            [1, 1, 1, 1, 0, 1] => Ok(AxisSet::XYZAC),
            [1, 1, 1, 1, 1, 1] => Ok(AxisSet::XYZABC),
            _ => Err("the joints must be x, y, z and c, each once, and may be a, or a and b".to_owned()),
        }
    }

    fn place(&self, link: &str) -> Result<Place, String> {
        let (mut at, mut axes, mut here) = (DAffine3::IDENTITY, Vec::new(), link);
        for _ in 0..DEEPEST {
            let Some(joint) = self.joints.get(here) else { return Ok(Place { at, axes }) };
            at = joint.origin * at;
            axes.extend(joint.axis);
            here = joint.parent;
        }
        Err(format!("link {link}: more than {DEEPEST} joints lead to it, or they go round"))
    }

    /// What the coordinates of bodies of this carrier are counted from, in the root's frame (m).
    fn counted_from(&self, carrier: Carrier) -> Result<DVec3, String> {
        let of = |link: &str| Ok(self.place(link)?.at.translation);
        match carrier {
            Carrier::Table | Carrier::Cradle | Carrier::Bed => Ok(DVec3::ZERO),
            Carrier::Head => {
                let turned = self.joints.iter().find(|(_, joint)| joint.axis == Some(Axis::C));
                of(turned.ok_or("there is no joint c, whose origin bodies of the head are counted from")?.0)
            }
            Carrier::Electrode if self.links.iter().any(|l| l.attribute("name") == Some("interface")) => {
                of("interface")
            }
            Carrier::Electrode => Err("there is no link interface, which the electrode would be held at".to_owned()),
        }
    }
}

/// The way that a machine counts `axis`, in the root's frame.
fn own_direction(axis: Axis) -> DVec3 {
    match axis {
        Axis::X => DVec3::X,
        Axis::Y | Axis::B => DVec3::Y,
        Axis::Z | Axis::C => DVec3::Z,
        Axis::A => DVec3::NEG_X,
    }
}

/// What a link goes with that these axes move.
fn carrier(axes: &[Axis]) -> Result<Carrier, String> {
    let has = |some: &[Axis]| axes.iter().any(|a| some.contains(a));
    let (slides, turns) = (has(&[Axis::X, Axis::Y, Axis::Z]), has(&[Axis::B, Axis::C]));
    match (has(&[Axis::A]), turns, slides) {
        (true, false, false) => Ok(Carrier::Table),
        (true, ..) => {
            Err("it goes with a and with another axis; the table turns about a only. A tilting table, whose c \
             turns what carries a, is given in a TOML file, with c_turns"
                .to_owned())
        }
        (false, true, true) => Ok(Carrier::Electrode),
        (false, true, false) => Err("b and c must be carried by x, y and z".to_owned()),
        (false, false, true) if !has(&[Axis::X]) || !has(&[Axis::Y]) || !has(&[Axis::Z]) => {
            Err("a slide that only some of x, y and z move cannot be simulated; leave it out".to_owned())
        }
        (false, false, true) => Ok(Carrier::Head),
        (false, false, false) => Ok(Carrier::Bed),
    }
}

fn axis_of(joint: &str) -> Option<Axis> {
    let last = joint.rsplit(['_', '-', ' ', '.', '/']).next()?;
    let mut letters = last.chars();
    let (letter, None) = (letters.next()?.to_ascii_uppercase(), letters.next()) else { return None };
    Axis::ALL.into_iter().find(|axis| axis.letter() == letter)
}

fn look(collision: Node, to_carrier: DAffine3, folder: &Path) -> Result<Look, String> {
    let geometry = child(collision, "geometry").ok_or("collision has no geometry")?;
    let shape = geometry.children().find(Node::is_element).ok_or("geometry is empty")?;
    let length =
        |key| number(shape, key)?.filter(|v| *v > 0.0 && *v < 10.0).ok_or(format!("{key} must be from 0 to 10 m"));
    let placed = |mesh: Mesh| Look::Made(mesh.mapped(|p| to_carrier.transform_point3(p)));
    match shape.tag_name().name() {
        "box" => {
            let size = vector(shape, "size", DVec3::ZERO)?;
            if size.min_element() <= 0.0 || size.max_element() >= 10.0 {
                return Err("size must be from 0 to 10 m along every axis".to_owned());
            }
            Ok(placed(super::cuboid(size * MM, DVec3::ZERO)))
        }
        "cylinder" => Ok(placed(super::cylinder(length("radius")? * MM, length("length")? * MM, 2, DVec3::ZERO))),
        "mesh" => {
            let file = attribute(shape, "filename")?;
            if file.contains("://") {
                return Err(format!("{file}: give the path of the mesh relative to this file"));
            }
            let scale = vector(shape, "scale", DVec3::ONE)?;
            if scale.min_element() <= 0.0 {
                return Err("scale must be greater than 0 along every axis".to_owned());
            }
            Ok(Look::File(folder.join(file), to_carrier * DAffine3::from_scale(scale * MM)))
        }
        other => Err(format!("{other} is not read; give a box, a cylinder or a mesh")),
    }
}

fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|n| n.has_tag_name(tag))
}

fn attribute<'a>(node: Node<'a, 'a>, key: &str) -> Result<&'a str, String> {
    node.attribute(key).ok_or_else(|| format!("{} has no {key}", node.tag_name().name()))
}

fn number(node: Node, key: &str) -> Result<Option<f64>, String> {
    let read = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    let wrong = |text: &str| format!("{key} is {text:?}; it must be a number");
    node.attribute(key).map(|text| read(text).ok_or_else(|| wrong(text))).transpose()
}

fn vector(node: Node, key: &str, default: DVec3) -> Result<DVec3, String> {
    let Some(text) = node.attribute(key) else { return Ok(default) };
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|t| t.parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if numbers.iter().all(|v: &f64| v.is_finite()) => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("{key} is {text:?}; it must be three numbers")),
    }
}

/// The origin that a joint or a shape has (m): roll, pitch and yaw about the fixed axes x, y and z.
fn origin(node: Node) -> Result<DAffine3, String> {
    let Some(origin) = node.children().find(|n| n.has_tag_name("origin")) else { return Ok(DAffine3::IDENTITY) };
    let [roll, pitch, yaw] = vector(origin, "rpy", DVec3::ZERO)?.to_array();
    let turned = DMat3::from_rotation_z(yaw) * DMat3::from_rotation_y(pitch) * DMat3::from_rotation_x(roll);
    Ok(DAffine3::from_mat3_translation(turned, vector(origin, "xyz", DVec3::ZERO)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::mesh::Bounds;

    const MACHINE: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/machine.urdf"));

    #[test]
    fn links_become_bodies_of_what_moves_them() {
        let bodies = bodies(MACHINE, Path::new("")).unwrap();
        let bounds = |name: &str| {
            let body = bodies.iter().find(|b| b.name == name).unwrap();
            let Look::Made(mesh) = &body.look else { panic!("{name}") };
            (body.carrier, Bounds::of(mesh.vertices.iter().copied()))
        };
        let near = |b: Bounds, min: [f64; 3], max: [f64; 3], by: f64| {
            let off = (b.min - DVec3::from(min)).abs().max((b.max - DVec3::from(max)).abs());
            assert!(off.max_element() <= by, "{b:?} {min:?} {max:?}");
        };
        let (carrier, bed) = bounds("bed");
        assert_eq!(carrier, Carrier::Bed);
        near(bed, [-200.0, -100.0, -350.0], [200.0, 100.0, -250.0], 1e-9);
        // The cylinder lies along x after a quarter turn about y.
        let (carrier, table) = bounds("table");
        assert_eq!(carrier, Carrier::Table);
        near(table, [-10.0, -50.0, -50.0], [10.0, 50.0, 50.0], 0.03);
        // Counted from the C axis, which is 50 mm aside and 200 mm below the ram's middle.
        let (carrier, ram) = bounds("ram");
        assert_eq!(carrier, Carrier::Head);
        near(ram, [-100.0, -50.0, 100.0], [0.0, 50.0, 300.0], 1e-9);
        let (carrier, chuck) = bounds("interface");
        assert_eq!(carrier, Carrier::Electrode);
        near(chuck, [0.0, -15.0, -15.0], [20.0, 15.0, 15.0], 1e-9);
    }

    #[test]
    fn limits_become_travels_and_the_slowest_axis_the_speed() {
        let table = table(MACHINE).unwrap();
        assert_eq!(table["axes"].as_str(), Some("XYZAC"));
        let travel = |key: &str| [0, 1].map(|i| table[key].as_array().unwrap()[i].as_float().unwrap());
        assert_eq!(travel("travel_x_mm"), [-250.0, 300.0]);
        assert!((travel("travel_a_deg")[1] - 180.0).abs() < 1e-9);
        assert!((table["speed_mm_min"].as_float().unwrap() - 600.0).abs() < 1e-9);
        assert!((table["speed_deg_min"].as_float().unwrap() - 0.5f64.to_degrees() * 60.0).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_be_simulated_is_refused_in_words() {
        let refused = |from: &str, to: &str, words: &str| {
            let text = MACHINE.replace(from, to);
            assert_ne!(text, MACHINE);
            let error = bodies(&text, Path::new("")).err().or(table(&text).err()).unwrap();
            assert!(error.contains(words), "{error}");
        };
        refused(r#"<joint name="X""#, r#"<joint name="lift""#, "must be called after an axis");
        refused(r#"name="interface""#, r#"name="nose""#, "there are 2: bed, nose");
        refused(r#""interface""#, r#""nose""#, "no link interface");
        refused("<box size=\"0.4 0.2 0.1\"/>", "<sphere radius=\"1\"/>", "sphere is not read");
        refused("0.4 0.2 0.1", "0.4 nan 0.1", "three numbers");
        refused(
            r#"<parent link="bed"/><child link="slide_x"/>"#,
            r#"<parent link="ram"/><child link="slide_x"/>"#,
            "go round",
        );
        refused("</robot>", "", "root node");
        assert!(table("<robot name=\"none\"/>").unwrap_err().contains("it has no link"));
        refused(r#""X" type="prismatic""#, r#""X" type="revolute""#, "that of X must be prismatic");
        refused("continuous", "prismatic", "that of A must be revolute or continuous");
        let along = |from: &str, to: &str, axis: &str| refused(from, to, &format!("along or about {axis} of the root"));
        let (slide, axis) = (r#"<parent link="bed"/><child link="slide_x"/>"#, |xyz| format!("<axis xyz=\"{xyz}\"/>"));
        along(slide, &(axis("-1 0 0") + slide), "1 0 0");
        along(slide, &(axis("0 0 0") + slide), "1 0 0");
        let table = r#"<parent link="bed"/><child link="table"/>"#;
        along(table, &(axis("1 0 0") + table), "-1 0 0");
        along(r#"<origin xyz="0 0 0.4"/>"#, r#"<origin xyz="0 0 0.4" rpy="0 0 1.5707963267948966"/>"#, "1 0 0");
        along(r#"<origin xyz="0.05 0 -0.2"/>"#, r#"<origin xyz="0.05 0 -0.2" rpy="0.01 0 0"/>"#, "0 0 1");
    }

    #[test]
    fn axes_that_go_the_way_that_the_machine_counts_them_may_be_given() {
        let with_axis = |text: String, child: &str, xyz: &str| {
            let carried = format!(r#"<child link="{child}"/>"#);
            assert!(text.contains(&carried), "{child}");
            text.replace(&carried, &format!(r#"{carried}<axis xyz="{xyz}"/>"#))
        };
        let text =
            [("table", "-1 0 0"), ("slide_x", "1 0 0"), ("slide_y", "0 1 0"), ("ram", "0 0 2"), ("spindle", "0 0 1")]
                .into_iter()
                .fold(MACHINE.to_owned(), |text, (child, xyz)| with_axis(text, child, xyz));
        assert_eq!(table(&text).unwrap(), table(MACHINE).unwrap());
        // Turned about its own axis C is the same.
        let turned = r#"<origin xyz="0.05 0 -0.2" rpy="0 0 0.7"/>"#;
        table(&MACHINE.replace(r#"<origin xyz="0.05 0 -0.2"/>"#, turned)).unwrap();
    }
}
