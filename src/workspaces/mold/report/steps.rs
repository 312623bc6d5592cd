//! Steps of the work with their times, as Table 1 of the paper on uncut detection and electrode design has them.

use serde::Serialize;
use task::StageTime;

/// Steps, each with the stages of jobs that belong to it. What is in none of them is a step of its own.
const STEPS: [(&str, &[&str]); 4] = [
    ("Uncut detection", &["height map", "layers", "surface"]),
    ("Electrode design", &["rest material", "electrodes"]),
    ("Refinement: reuse and shared bases", &["sharing"]),
    ("Checks, residual stock included", &["checks"]),
];

/// Time of a step of the work.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepTime {
    /// Step.
    pub step: String,
    /// Stages that it consists of.
    pub stages: Vec<String>,
    /// Time (s).
    pub seconds: f64,
}

/// Times of the steps of jobs, in the order of the work.
pub fn steps(times: &[StageTime]) -> Vec<StepTime> {
    let step_of = |stage: &str| STEPS.iter().find(|(_, stages)| stages.contains(&stage)).map(|(step, _)| *step);
    let mut steps: Vec<StepTime> = Vec::new();
    for StageTime { stage, seconds } in times {
        let step = step_of(stage).map_or_else(|| capital(stage), str::to_owned);
        match steps.iter_mut().find(|known| known.step == step) {
            Some(known) => {
                known.seconds += seconds;
                if !known.stages.contains(stage) {
                    known.stages.push(stage.clone());
                }
            }
            None => steps.push(StepTime { step, stages: vec![stage.clone()], seconds: *seconds }),
        }
    }
    steps
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_summed_to_steps() {
        let times =
            [("height map", 1.0), ("layers", 2.0), ("electrodes", 4.0), ("height map", 8.0), ("pictures", 16.0)];
        let steps = steps(&times.map(|(stage, seconds)| StageTime { stage: stage.to_owned(), seconds }));
        let told: Vec<_> = steps.iter().map(|s| (&*s.step, s.stages.join(" "), s.seconds)).collect();
        assert_eq!(
            told,
            [
                ("Uncut detection", "height map layers".to_owned(), 11.0),
                ("Electrode design", "electrodes".to_owned(), 4.0),
                ("Pictures", "pictures".to_owned(), 16.0)
            ]
        );
    }
}
