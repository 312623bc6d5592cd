//! Minutes and wear of an electrode in one call.

use serde::Serialize;

use crate::BurningError;
use crate::choice::{Burn, Until, choose, named};
use crate::duration::{BurnTime, Calibrated, time_of};
use crate::technology::{Technology, TechnologyFile};
use crate::wear::Wear;

/// Minutes and wear of an electrode in one burn, with the figures that they rest on and those that are missing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// Time, scaled by the finished burns of the technology.
    pub time: BurnTime,
    /// Wear.
    pub wear: Wear,
}

impl TechnologyFile {
    /// Minutes and wear of an electrode that burns with this technology, scaled by the finished burns of the technology.
    ///
    /// # Errors
    /// [`BurningError`] if there is no such technology, if the burn, the technology or a finished burn is not possible,
    /// if no step is fine enough, or if the last step does not suit the burn.
    pub fn estimate(&self, id: &str, burn: &Burn) -> Result<Estimate, BurningError> {
        let technology = self.find(id)?;
        let choice = choose(technology, burn)?;
        let calibration = Calibrated::from_burns(self.calibrations_of(id))?;
        Ok(Estimate { time: time_of(&choice, calibration)?, wear: Wear::of_burn(&choice) })
    }

    /// Checks that there is a technology of this id, and that it has the step at which burning ends.
    ///
    /// # Errors
    /// [`BurningError::NoSuchTechnology`] or [`BurningError::NoSuchStep`].
    pub fn check_end(&self, id: &str, until: &Until) -> Result<(), BurningError> {
        let technology = self.find(id)?;
        match until {
            Until::Step(step) => named(technology, step).map(|_| ()),
            Until::Vdi(_) | Until::RaUm(_) => Ok(()),
        }
    }

    fn find(&self, id: &str) -> Result<&Technology, BurningError> {
        self.get(id).ok_or_else(|| {
            let ids: Vec<&str> = self.technology.iter().map(|technology| technology.id.as_str()).collect();
            BurningError::NoSuchTechnology { id: id.to_owned(), ids: ids.join(", ") }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::Until;
    use crate::choice::tests::{burn, complete};
    use crate::technology::{Calibration, Technology};

    /// 985 mm³ at 1 %, 10 mm³ at 5 % and 5 mm³ at 20 % from 100 mm²; 28.125 minutes with jumps, of which 1.2 are measured.
    #[test]
    fn one_call_answers_minutes_and_wear() {
        let finished = |technology: &str, measured_min| Calibration {
            technology: technology.to_owned(),
            estimated_min: 10.0,
            measured_min,
            date: None,
            source: None,
        };
        let other = Technology { id: "other".to_owned(), source: "elsewhere".to_owned(), ..complete() };
        let mut file = TechnologyFile {
            technology: vec![complete(), other],
            calibration: vec![finished("other", 90.0), finished("complete", 11.0), finished("complete", 13.0)],
        };
        let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
        let answer = file.estimate("complete", &asked).unwrap();
        let minutes = 1.05 * (985.0 / 40.0 + 10.0 / 10.0 + 5.0 / 2.0);
        let burning = answer.time.burning.unwrap();
        assert!((burning.mean - 1.2 * minutes).abs() < 1e-9, "the finished burns of its own technology");
        assert!((burning.greatest.unwrap() - 1.3 * minutes).abs() < 1e-9);
        assert_eq!(answer.time.calibration.map(|calibrated| calibrated.count), Some(2));
        assert!((answer.wear.end_mm.unwrap() - 0.1135).abs() < 1e-12);
        assert_eq!(file.estimate("other", &asked).unwrap().time.source, "elsewhere");
        let said = file.estimate("none", &asked).unwrap_err().to_string();
        assert_eq!(said, "there is no technology none; those of the file are complete, other");
        file.calibration[1].measured_min = -1.0;
        assert!(file.estimate("complete", &asked).unwrap_err().to_string().contains("measured_min is -1"));
    }
}
