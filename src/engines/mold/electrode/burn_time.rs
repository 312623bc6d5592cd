//! Minutes and wear of electrodes, with a technology.

use super::design::{Burn, Electrode, ElectrodeSet};
use super::params::Stage;
use burning::choice::{Burn as BurnTask, Piece};
use burning::duration::{Overhead, sum_of};
use burning::figures::BurnFigures;
use burning::project::ProjectTechnology;
use burning::technology::TechnologyFile;
use burning::wear::share_out;

/// Reason why there are no minutes of a burn.
const NO_VOLUME: &str = "the volume or the area seen along the burn is not known";

impl ElectrodeSet {
    /// The electrodes with minutes and wear by the technology of their parameters, which `table` has; with its reason
    /// where there is no table.
    ///
    /// The heads of a burn go down together, so that those with more stock begin earlier. The volume of a burn is what
    /// the stages before have left; it counts as spread over the area seen along the burn. Steps whose side gap is greater
    /// than that of the stage are not taken.
    #[must_use]
    pub fn timed(mut self, table: Result<&TechnologyFile, &str>) -> Self {
        let project = &self.params.technology;
        for electrode in &mut self.electrodes {
            let Some(stage) = self.params.stages.get(electrode.stage) else { continue };
            let area = electrode.burn_area;
            let of_heads = |heads: Option<&[Piece]>| match table {
                Ok(table) => figures(heads, (stage, area), table, project),
                Err(why) => BurnFigures::unknown(why),
            };
            time(electrode, &of_heads);
        }
        self
    }
}

impl Electrode {
    /// Number of electrodes that the burns need, in words.
    pub fn needed_text(&self) -> String {
        self.needed.map_or_else(|| "not known".to_owned(), |needed| self.figures.needed_text(needed))
    }
}

/// Puts the figures of each burn, of all of them, and of the other way into an electrode.
fn time(electrode: &mut Electrode, of_heads: &dyn Fn(Option<&[Piece]>) -> BurnFigures) {
    let of_burn = |burn: &Burn| of_heads(burn.heads.as_deref());
    let burns: Vec<BurnFigures> = electrode.burns.iter().map(of_burn).collect();
    electrode.burns.iter_mut().zip(&burns).for_each(|(burn, figures)| burn.minutes = figures.minutes);
    let shares: Vec<f64> = burns.iter().map(|figures| figures.wear_share.at_least()).collect();
    electrode.needed = share_out(&shares).ok().map(|copies| copies.count);
    electrode.figures = BurnFigures::all_of(&burns);
    if let Some(way) = &mut electrode.other_way {
        // Each place has its head: of burns one after another the burn's own, else the head's.
        let all: Option<Vec<&Vec<Piece>>> = electrode.burns.iter().map(|burn| burn.heads.as_ref()).collect();
        let all: Option<Vec<Piece>> = all.map(|heads| heads.into_iter().flatten().copied().collect());
        let of_places = |places: &Vec<usize>| {
            let own: Option<Vec<Piece>> =
                all.as_ref().and_then(|all| places.iter().map(|place| all.get(*place).copied()).collect());
            of_heads(own.as_deref()).minutes
        };
        way.minutes = sum_of(way.at_once.iter().map(of_places), Overhead::default()).ok().flatten();
    }
}

/// Figures of a burn with these heads, of an electrode of this stage and burning area (mm^2).
fn figures(
    heads: Option<&[Piece]>,
    (stage, area): (&Stage, f64),
    table: &TechnologyFile,
    project: &ProjectTechnology,
) -> BurnFigures {
    let Some(pieces) = heads.and_then(Piece::together) else { return BurnFigures::unknown(NO_VOLUME) };
    if pieces.is_empty() {
        return BurnFigures::idle();
    }
    // A technology that knows no orbit burns with that of the stage, beside its gap.
    let knows_orbits = table.get(&project.id).is_some_and(|t| t.step.iter().all(|step| step.orbit_mm.is_some()));
    let orbit = if knows_orbits { stage.orbit.radius_mm() } else { 0.0 };
    let task = BurnTask {
        burned_area_mm2: (area > 0.0).then_some(area),
        undersize_mm: Some(stage.gap_mm + orbit),
        depth_to_width: None,
        from: None,
        until: stage.until(),
        pieces,
    };
    BurnFigures::of(table, project, &task)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::electrode::params::ElectrodeParams;
    use crate::electrode::tests::{mold, params, planned, region};
    use crate::fixtures::rectangle;
    use burning::project::ProjectTechnology;
    use burning::technology::TECHNOLOGY_FILE;
    use glam::DVec2;

    /// 2 mm³ a minute on 10 mm² or more, 10 % wear, one step.
    fn table() -> TechnologyFile {
        let text = "[[technology]]\nid = \"t\"\nsource = \"test\"\nbasis = \"assumed\"\n\
                    electrode_material = \"copper\"\nworkpiece = \"steel\"\n[[technology.step]]\nname = \"S\"\n\
                    vdi = 20.0\nrate_mm3_min = 2.0\nat_area_mm2 = 10.0\nwear_percent = 10.0\ngap_side_mm = 0.05\n";
        TECHNOLOGY_FILE.parse(text, std::path::Path::new("t.toml")).unwrap()
    }

    /// One slot of 8 mm by 2 mm of which 64 mm³ are left.
    fn slot(technology: ProjectTechnology) -> ElectrodeSet {
        let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 2.0), 5.0)]);
        let mut slot = region(&mold, DVec2::new(-4.1, -1.1), DVec2::new(4.1, 1.1));
        slot.volume = 64.0;
        planned(&mold, &[slot], &ElectrodeParams { technology, ..params(0.1) })
    }

    fn project() -> ProjectTechnology {
        ProjectTechnology { id: "t".to_owned(), ..ProjectTechnology::default() }
    }

    #[test]
    fn minutes_are_the_volume_by_the_rate_on_the_front() {
        let set = slot(project()).timed(Ok(&table()));
        let electrode = &set.electrodes[0];
        let head = electrode.burns[0].heads.as_ref().unwrap()[0];
        assert!((head.volume_mm3 - 64.0).abs() < 1e-9, "{head:?}");
        // Above 10 mm² the step has its full rate: 32 minutes.
        assert!(head.frontal_area_mm2 > 10.0, "{head:?}");
        let minutes = electrode.figures.minutes.unwrap().mean;
        assert!((minutes - 32.0).abs() < 1e-9, "{minutes}");
        assert_eq!(
            (electrode.burns[0].minutes, set.minutes().map(|m| m.mean)),
            (electrode.figures.minutes, Some(minutes))
        );
        let wear = 0.1 * 64.0 / head.frontal_area_mm2;
        assert!((electrode.figures.end_wear_mm.unwrap() - wear).abs() < 1e-9);
        assert_eq!(electrode.figures.corner_wear_mm, None, "corner wear is not considered");
        let mut limited = project();
        limited.allowed_wear.end_mm = Some(0.45 * wear);
        assert_eq!(slot(limited).timed(Ok(&table())).electrodes[0].needed, Some(3));
        let mut overhead = project();
        overhead.overhead = Overhead { setup_min: 20.0, change_min: 3.0 };
        let set = slot(overhead).timed(Ok(&table()));
        assert!((set.minutes().unwrap().mean - 52.0).abs() < 1e-9, "set up once, nothing to change to");
    }

    #[test]
    fn what_is_missing_gives_no_minutes_and_never_zero() {
        let untimed = slot(project());
        assert_eq!((untimed.minutes(), untimed.electrodes[0].figures.minutes), (None, None));
        let unread = slot(project()).timed(Err("t.toml: cannot be read"));
        assert_eq!(unread.minutes(), None);
        assert_eq!(unread.electrodes[0].figures.missing, ["t.toml: cannot be read"]);
        let mut without = table();
        without.technology[0].step[0].rate_mm3_min = None;
        let set = slot(project()).timed(Ok(&without));
        assert_eq!((set.minutes(), set.electrodes[0].burns[0].minutes), (None, None));
        assert_eq!(set.electrodes[0].figures.missing, ["rate of step S is not given"]);
        let mut unknown = slot(project());
        unknown.electrodes[0].burns[0].heads = None;
        assert_eq!(unknown.timed(Ok(&table())).electrodes[0].figures.missing, [NO_VOLUME]);
        // A spark gap that is smaller than that of the step.
        let mut fine = slot(project());
        fine.params.stages[0].gap_mm = 0.04;
        let figures = fine.timed(Ok(&table())).electrodes.remove(0).figures;
        assert!(figures.minutes.is_none() && figures.missing[0].contains("has 0.04 mm to burn in"), "{figures:?}");
    }
}
