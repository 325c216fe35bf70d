//! The date of an FMU. The clock is never read: the same scene gives the same bytes. Set SOURCE_DATE_EPOCH (seconds since
//! 1970-01-01 UTC) to get a date, as for reproducible builds.

use camdrive::drives::Fault;

/// A date and time of the Gregorian calendar, UTC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Date {
    /// For example 2026.
    pub year: i64,
    /// 1 … 12.
    pub month: i64,
    /// 1 … 31.
    pub day: i64,
    /// 0 … 23.
    pub hour: i64,
    /// 0 … 59.
    pub minute: i64,
    /// 0 … 59.
    pub second: i64,
}

/// 9999-12-31T23:59:59Z, the last instant with a year of four digits.
const LAST: i64 = 253_402_300_799;

impl Date {
    /// The date in the environment variable SOURCE_DATE_EPOCH, if it is set.
    pub fn from_environment() -> Result<Option<Date>, Fault> {
        let Some(value) = std::env::var_os("SOURCE_DATE_EPOCH") else { return Ok(None) };
        let seconds = value.to_str().and_then(|text| text.trim().parse().ok()).filter(|s| (0..=LAST).contains(s));
        seconds.map(|s| Some(Date::from_epoch(s))).ok_or_else(|| {
            Fault::new(format!(
                "SOURCE_DATE_EPOCH = `{}` is not a number of seconds since 1970 from 0 to {LAST}",
                value.to_string_lossy()
            ))
        })
    }

    /// The date `seconds` after 1970-01-01T00:00:00Z, seconds ≥ 0.
    ///
    /// The years start on 1 March, so that the leap day is their last; 400 years have 146097 days.
    pub fn from_epoch(seconds: i64) -> Date {
        let (days, rest) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
        // 719468 days lie between 0000-03-01 and 1970-01-01.
        let days = days + 719_468;
        let (era, day_of_era) = (days / 146_097, days % 146_097);
        let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
        let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        // From March on, five months always have 153 days.
        let month_from_march = (5 * day_of_year + 2) / 153;
        let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
        let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
        let year = 400 * era + year_of_era + i64::from(month <= 2);
        Date { year, month, day, hour: rest / 3600, minute: rest / 60 % 60, second: rest % 60 }
    }

    /// As `xs:dateTime`, the format of generationDateAndTime.
    pub fn iso(self) -> String {
        let Date { year, month, day, hour, minute, second } = self;
        format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_one_can_look_up() {
        for (seconds, iso) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_000_000_000, "2001-09-09T01:46:40Z"),
            (4_107_542_399, "2100-02-28T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
            (LAST, "9999-12-31T23:59:59Z"),
        ] {
            assert_eq!(Date::from_epoch(seconds).iso(), iso);
        }
    }
}
