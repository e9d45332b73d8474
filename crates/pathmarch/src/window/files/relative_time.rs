//! Relative time, such as "5 min ago": needs no time zone.

use std::time::{SystemTime, UNIX_EPOCH};

const MINUTE: u64 = 60;
const HOUR: u64 = 60 * MINUTE;
const DAY: u64 = 24 * HOUR;

/// Formats a time as "just now", "5 min ago", "3 h ago" or "12 days ago"; older than a month as a date, "2025-03-12"
/// (UTC).
pub fn relative_time(time: SystemTime, now: SystemTime) -> String {
    // A time in the future (a wrong clock) counts as now.
    let seconds = now.duration_since(time).unwrap_or_default().as_secs();
    match seconds {
        0..MINUTE => "just now".to_owned(),
        MINUTE..HOUR => format!("{} min ago", seconds / MINUTE),
        HOUR..DAY => format!("{} h ago", seconds / HOUR),
        _ => match seconds / DAY {
            1 => "1 day ago".to_owned(),
            days @ 2..=30 => format!("{days} days ago"),
            _ => date(time),
        },
    }
}

/// Date in UTC, as in "2025-03-12"; empty before 1970.
///
/// Source: `civil_from_days` of Howard Hinnant, "chrono-Compatible Low-Level Date Algorithms", 2013, for days since 1970.
fn date(time: SystemTime) -> String {
    let Ok(since) = time.duration_since(UNIX_EPOCH) else { return String::new() };
    let days = since.as_secs() / DAY + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn ages_read_well() {
        let now = UNIX_EPOCH + Duration::from_secs(1_800_000_000);
        for (seconds, words) in [
            (0, "just now"),
            (59, "just now"),
            (60, "1 min ago"),
            (3599, "59 min ago"),
            (3600, "1 h ago"),
            (DAY, "1 day ago"),
            (30 * DAY, "30 days ago"),
            (100 * DAY, "2026-10-07"),
        ] {
            assert_eq!(relative_time(now - Duration::from_secs(seconds), now), words);
        }
        assert_eq!(relative_time(now + Duration::from_secs(99), now), "just now");
        assert_eq!(relative_time(UNIX_EPOCH - Duration::from_secs(1), now), "");
    }

    #[test]
    fn dates_are_right() {
        for (days, text) in [(0, "1970-01-01"), (59, "1970-03-01"), (11_016, "2000-02-29"), (20_454, "2026-01-01")] {
            assert_eq!(date(UNIX_EPOCH + Duration::from_secs(days * DAY)), text);
        }
    }
}
