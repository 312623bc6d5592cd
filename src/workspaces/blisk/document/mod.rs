//! The document of a blisk: the parameters of its plan, and what a project keeps of plans.

pub mod burning;
pub mod choice;
pub mod job_file;
pub mod kept_plan;
pub mod machine_file;
pub mod scan;
pub mod setting;
pub mod setup;
pub mod stage;

use std::path::Path;

use crate::workspaces::blisk::document::job_file::PlanJob;

/// The document of the workspace.
pub type Document = files::Document<PlanJob>;

/// The built-in demonstration, with its plan.
pub fn demonstration() -> Document {
    let built_in = include_str!("../../../../assets/demonstration.sparkpath");
    // A test opens it; were it damaged, the demonstration would start without its plan.
    Document::parse(built_in, Path::new("")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use files::{AnyDocument as _, Field, Invalid, Kind};

    use super::job_file::field_table::FIELDS;
    use super::kept_plan::{KeptPlan, KeptRun, check};
    use super::*;

    fn field(key: &str) -> &'static Field {
        FIELDS.find(key).unwrap().field
    }

    #[test]
    fn the_demonstration_comes_with_a_plan_for_its_own_parameters() {
        let document = demonstration();
        assert_eq!(*document.params(), PlanJob::demonstration());
        let plan = KeptPlan::of(&document)
            .expect("open the demonstration, plan, and save it as assets/demonstration.sparkpath");
        assert_eq!(plan.inputs, KeptPlan::inputs_of(document.params(), ""), "plan it again, and save it");
    }

    #[test]
    fn plans_survive_saving_and_opening_to_the_last_bit_and_damaged_ones_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let [mesh, file] = ["part.stl", "a.sparkpath"].map(|name| folder.path().join(name));
        std::fs::write(&mesh, "solid").unwrap();
        let mut job = PlanJob::for_mesh(&mesh);
        job.electrode.circumferential_reduction_deg = [0.1 + 0.2, 1.0 / 3.0];
        job.blisk.options.blades = wheel::options::Auto::Given(60);
        let plan = KeptPlan::of(&demonstration()).unwrap();
        let run = KeptRun::new(3, 1, job.clone(), plan.clone());
        assert_eq!(run.job.blisk.mesh.as_deref(), Some(Path::new("part.stl")), "no path that another computer has not");
        let mut document = Document::new(job.clone());
        plan.note(&mut document);
        assert!(!document.is_unsaved(), "the same search finds it again");
        KeptRun::keep(std::slice::from_ref(&run), &mut document).unwrap();
        assert!(document.is_unsaved(), "its parameters may be nowhere else");
        document.save_as(&file).unwrap();
        let mut read = Document::open(&file).unwrap();
        assert_eq!((read.params(), KeptPlan::of(&read), KeptRun::all_of(&read)), (&job, Some(plan), vec![run]));
        assert_eq!(check(&read), Ok(()));
        let run = KeptRun::all_of(&read).remove(0);
        KeptRun::keep(&vec![run.clone(); KeptRun::MOST], &mut read).unwrap();
        assert_eq!(check(&read), Ok(()));
        KeptRun::keep(&vec![run.clone(); KeptRun::MOST + 1], &mut read).unwrap();
        let said = check(&read).unwrap_err();
        assert!(said.contains("keeps 7 plans") && said.contains("remove the others"), "{said}");
        // What is too large to be kept leaves what there is.
        let revision = read.kept_revision();
        let nodes = vec![run.plan.electrodes[0].nodes[0]; KeptRun::MOST_BYTES / 8];
        let mut large = run.clone();
        large.plan.electrodes[0].nodes = nodes;
        let said = KeptRun::keep(&[large], &mut read).unwrap_err();
        assert!(said.contains("at most 16 MiB") && said.contains("larger step"), "{said}");
        assert_eq!((read.kept_revision(), KeptRun::all_of(&read).len()), (revision, KeptRun::MOST + 1));
        read.keep("runs", Some("[{".to_owned()));
        assert!(check(&read).unwrap_err().contains("kept.runs"));
        read.note_result("plan", Some("{}".to_owned()));
        assert!(check(&read).unwrap_err().contains("results.plan"));
    }

    #[test]
    fn a_value_is_set_by_its_key_and_a_machine_brings_its_axes_along() {
        let job = PlanJob::for_mesh("part.stl".as_ref());
        let changed = FIELDS.set(&job, "electrode.circumferential_reduction_deg[1]", "1.25").unwrap();
        assert_eq!(changed.electrode.circumferential_reduction_deg, [0.8, 1.25]);
        let line = FIELDS.set(&job, "blisk.axis", "{ direction = [0, 0, 2], point = [1, 2, 3] }").unwrap();
        assert!(matches!(line.blisk.options.axis, wheel::options::AxisChoice::Line(_)));
        let channels = FIELDS.set(&job, "export.channels", "0, 2").unwrap().export.channels;
        assert_eq!(channels.numbers(4, 0), Ok(vec![0, 2]));
        assert!(FIELDS.set(&job, "export.channels", "some").is_err());
        let with = |job: &PlanJob, name: &str| {
            let mut job = FIELDS.set(job, "machine.name", name)?;
            files::Params::complete(&mut job, &|key| key == "machine.name")?;
            Ok::<_, Invalid>(job)
        };
        let six = with(&job, "xyzabc").unwrap();
        assert_eq!((six.machine.axes, six.machine.has_bodies()), (feed::machine::AxisSet::XYZABC, true));
        let none = with(&six, "").unwrap();
        assert_eq!((none.machine.axes, none.machine.has_bodies()), (six.machine.axes, false));
        assert!(with(&job, "nowhere/mine.toml").unwrap_err().to_string().contains("cannot be read"));
        assert!(matches!(field("machine.name").kind, Kind::ChoiceOrFile(_)));
    }
}
