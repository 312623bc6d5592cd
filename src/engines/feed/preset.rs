//! Presets: how an electrode stands on its holder against its nominal place, and the feed that makes up for it.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::path::{FeedPath, PathRow};
use super::quantise::quantise_path;

/// Place of an electrode on its holder less the nominal one, measured with all axes of the machine at zero.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// Along X of W (mm).
    pub x_mm: f64,
    /// Along Y of W (mm).
    pub y_mm: f64,
    /// Along Z of W (mm).
    pub z_mm: f64,
    /// Turn about Z of W, at the nominal axis of C, or of the electrode where C turns the table (degrees).
    pub c_deg: f64,
    /// Greatest error of the measurement along each axis (mm).
    pub uncertainty_mm: f64,
    /// Way along X, Y and Z of W by which the electrode goes beyond the final pose of a new one, for the length that its front
    /// has lost (mm).
    #[serde(default)]
    pub advance_mm: [f64; 3],
    /// Way along X and Y of W, in the final pose of a nominal electrode, from the axis of the table that C turns to the nominal
    /// axis of the electrode (mm); none where C turns the electrode.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table_arm_mm: Option<[f64; 2]>,
}

/// Greatest offset that is taken for a preset (mm), and greatest turn (degrees): more is a mistake, or another electrode.
pub const MOST_OFF: [f64; 2] = [5.0, 10.0];

impl Preset {
    /// Values of X, Y, Z (mm) and C (rad) that bring the electrode into its final pose, where a nominal electrode has all at 0.
    pub fn zero(&self) -> [f64; 4] {
        let c = -self.c_deg.to_radians();
        let shift = self.shift();
        let slide = match self.table_arm_mm {
            None => shift,
            // The table takes the blisk to where the turned electrode fits, and the slides bring the electrode there.
            Some(arm) => {
                let arm = DVec2::from(arm).extend(0.0);
                DMat3::from_rotation_z(-c) * (arm + shift) - arm
            }
        };
        [slide.x, slide.y, slide.z, c].map(|value| value + 0.0)
    }

    /// Way from the reference point of a nominal electrode to that of this one, both in their final poses, in W (mm).
    fn shift(&self) -> DVec3 {
        let offset = DVec3::new(self.x_mm, self.y_mm, self.z_mm);
        DVec3::from(self.advance_mm) - DMat3::from_rotation_z(-self.c_deg.to_radians()) * offset
    }

    /// Angle by which X and Y of the machine are turned about Z against W in the final pose (rad): where C turns the table, it
    /// has turned the blisk.
    pub fn turned(&self) -> f64 {
        if self.table_arm_mm.is_some() { self.c_deg.to_radians() } else { 0.0 }
    }

    /// Motion of a part of the head, as seen from the blisk, from where it is in the final pose of a nominal electrode with this
    /// reference point to where it is in that of this one. `turns`: whether C turns it against the slides.
    pub fn of_head(&self, nominal: DVec3, turns: bool) -> DAffine3 {
        let turned = self.table_arm_mm.is_some() || turns;
        let matrix3 = if turned { DMat3::from_rotation_z(-self.c_deg.to_radians()) } else { DMat3::IDENTITY };
        DAffine3 { matrix3, translation: nominal + self.shift() - matrix3 * nominal }
    }

    /// Motion of what stands on the bed, as [`of_head`](Self::of_head), about the point `axis` of the axis that C turns about.
    pub fn of_bed(&self, axis: DVec3) -> DAffine3 {
        let matrix3 = DMat3::from_rotation_z(-self.turned());
        DAffine3 { matrix3, translation: axis - matrix3 * axis }
    }

    /// Reference point of the electrode, which B and C turn about where they turn it, in its final pose; a nominal electrode has
    /// `nominal` (mm, in W).
    pub fn reference_point(&self, nominal: DVec3) -> DVec3 {
        nominal + self.shift()
    }

    /// The reference point of a nominal electrode, where that of this one is `own` (mm, in W).
    pub fn nominal(&self, own: DVec3) -> DVec3 {
        own - self.shift()
    }

    /// Length that the front of the electrode has lost (mm).
    pub fn wear_mm(&self) -> f64 {
        DVec3::from(self.advance_mm).length()
    }

    /// The preset in a sentence.
    pub fn sentence(&self) -> String {
        let [x, y, z, c] = self.zero();
        let Self { x_mm, y_mm, z_mm, c_deg, uncertainty_mm, .. } = self;
        let worn = match self.wear_mm() {
            0.0 => String::new(),
            wear => format!(
                ". Its front has lost {wear:.4} mm by the wear of the technology, and it goes on by as much, which is in these \
                 values; the places are those that were measured when it was new"
            ),
        };
        format!(
            "Preset: the electrode stands X {x_mm} Y {y_mm} Z {z_mm} mm, C {c_deg} deg off nominal on its holder, measured to \
             {uncertainty_mm} mm, an error that the certificate does not contain. The final pose, where all axes are zero, is at X \
             {x:.5} Y {y:.5} Z {z:.5} C {:.6} of a nominal electrode's: set the work zero there, or shift that of a nominal \
             electrode by these values{worn}",
            c.to_degrees()
        )
    }

    /// `path` for the electrode as it stands: at each row the electrode is where the nominal one is, moved on in its own axes by
    /// its advance, with the axes counted from [`zero`](Self::zero). It has to be verified anew, because the motion between the rows is another.
    #[must_use]
    pub fn path(&self, path: &FeedPath) -> FeedPath {
        let (from, to) = (path.reference_point, self.reference_point(path.reference_point));
        let row = |row: &PathRow| PathRow { pose: row.pose.about(from, to), ..*row };
        let rows = path.rows.iter().map(row).collect();
        quantise_path(&FeedPath { reference_point: to, rows, ..path.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::Chain;
    use crate::pose::Pose;
    use geometry::frame::Frame;

    const O: DVec3 = DVec3::new(3.0, -1.0, 110.0);

    fn preset() -> Preset {
        let advance_mm = [0.12, 0.0, -0.05];
        Preset { x_mm: 0.4, y_mm: -0.25, z_mm: 0.1, c_deg: 1.5, uncertainty_mm: 0.002, advance_mm, table_arm_mm: None }
    }

    /// Where the machine with these axis values has a point of the electrode that stands on its holder as `preset` says:
    /// written down anew, from the nominal axis of C.
    fn on_machine(preset: &Preset, [x, y, z, a, c]: [f64; 5], p: DVec3) -> DVec3 {
        let offset = DVec3::new(preset.x_mm, preset.y_mm, preset.z_mm);
        let on_holder = offset + DMat3::from_rotation_z(preset.c_deg.to_radians()) * (p - O);
        let turned = DMat3::from_rotation_z(c) * on_holder;
        DMat3::from_rotation_x(a) * (O + DVec3::new(x, y, z) + turned)
    }

    #[test]
    fn the_electrode_as_it_stands_is_where_the_nominal_one_is() {
        let preset = preset();
        let poses = [
            Pose { x: -30.0, y: 2.0, z: 1.0, a: 0.05, b: 0.0, c: 0.3 },
            Pose { x: -12.0, y: 1.0, z: 0.5, a: -0.1, b: 0.0, c: -0.2 },
            Pose::FINAL,
        ];
        let rows = poses.map(|pose| PathRow { node: 0, s: -pose.x, pose }).to_vec();
        let nominal = FeedPath { frame: Frame::IDENTITY, reference_point: O, spark_gap: 0.1, rows };
        let path = preset.path(&nominal);
        let [x0, y0, z0, c0] = preset.zero();
        for (row, pose) in path.rows.iter().zip(&poses) {
            let p = DVec3::new(7.0, -4.0, 118.0);
            let Pose { x, y, z, a, c, .. } = row.pose;
            let placed = on_machine(&preset, [x0 + x, y0 + y, z0 + z, a, c0 + c], p);
            // An electrode that is moved on in its own axes has its points where the nominal one has others.
            let moved = p + DVec3::from(preset.advance_mm);
            let expected = pose.placement(O).transform_point3(moved);
            // The rows are rounded as files are.
            assert!(placed.distance(expected) < 2e-5, "{placed} {expected}");
            // The program of the path is of the same formula about its own reference point.
            let by_path = row.pose.placement(path.reference_point).transform_point3(moved);
            assert!(by_path.distance(expected) < 2e-5, "{by_path} {expected}");
        }
        assert_eq!(path.rows[2].pose, Pose::FINAL);
        assert_ne!(path.digest(), nominal.digest());
    }

    /// A table that C turns about `Q`, with A on it: from the bed, joint by joint.
    #[test]
    fn on_a_table_that_c_turns_the_blisk_comes_to_where_the_electrode_fits() {
        const Q: DVec3 = DVec3::new(-60.0, 4.0, 0.0);
        let arm = (O - Q).truncate();
        let preset = Preset { table_arm_mm: Some(arm.into()), ..preset() };
        let straight = Preset { c_deg: 0.0, ..preset };
        let pose = |[x, y, z, a, b, c]: [f64; 6]| Pose { x, y, z, a, b, c };
        for (preset, pose) in [
            (preset, pose([-30.0, 2.0, 1.0, 0.05, 0.0, 0.3])),
            (preset, pose([-12.0, 1.0, 0.5, -0.1, 0.0, -0.2])),
            (preset, Pose::FINAL),
            // Only an electrode that is not turned may be tilted.
            (straight, pose([-12.0, 1.0, 0.5, -0.1, 0.15, -0.2])),
        ] {
            let own = preset.reference_point(O);
            assert!(preset.nominal(own).distance(O) < 1e-12);
            let chain = Chain::new(own, Some(Q.truncate())).turned(preset.turned());
            let [x0, y0, z0, c0] = preset.zero();
            let of_row = pose.about(O, own);
            let Pose { x, y, z, a, b, c } = chain.machine_pose(&of_row);
            let slides = DVec3::new(x0 + x, y0 + y, z0 + z);
            let of_part = |on_head: DVec3| {
                let from_axis = DMat3::from_rotation_z(c0 + c) * (on_head + slides - Q);
                DMat3::from_rotation_x(a) * (Q + from_axis)
            };
            let p = DVec3::new(7.0, -4.0, 118.0);
            let offset = DVec3::new(preset.x_mm, preset.y_mm, preset.z_mm);
            let on_holder = offset + DMat3::from_rotation_z(preset.c_deg.to_radians()) * (p - O);
            let tilted = O + DMat3::from_rotation_y(b) * on_holder;
            let expected = pose.placement(O).transform_point3(p + DVec3::from(preset.advance_mm));
            assert!(of_part(tilted).distance(expected) < 1e-9, "{} {expected}", of_part(tilted));
            // The head and the bed, as a simulation moves them from where they are in the final pose.
            let head = Pose { b: 0.0, ..of_row }.placement(own) * preset.of_head(O, false);
            assert!(of_part(p).distance(head.transform_point3(p)) < 1e-9);
            let on_bed = DMat3::from_rotation_x(a) * (Q + DMat3::from_rotation_z(c0 + c) * (p - Q));
            let bed = Pose { a: pose.a, c: pose.c, ..Pose::FINAL }.placement(Q) * preset.of_bed(Q);
            assert!(on_bed.distance(bed.transform_point3(p)) < 1e-9);
        }
    }

    #[test]
    fn a_nominal_electrode_keeps_its_path() {
        let rows = vec![PathRow { node: 0, s: 5.0, pose: Pose { x: -5.0, c: 0.1, ..Pose::FINAL } }];
        let nominal = quantise_path(&FeedPath { frame: Frame::IDENTITY, reference_point: O, spark_gap: 0.1, rows });
        assert_eq!(Preset::default().path(&nominal), nominal);
        assert_eq!(Preset::default().zero(), [0.0; 4]);
    }
}
