//! Resolution of calendars: shifts with their weekdays and breaks, the first day of a run, and
//! holidays.

use super::Builder;
use crate::contract::calendar::{Shift, WorkCalendar, after, microseconds};
use crate::contract::date::{WEEKDAYS, days_in_month, days_since_1970, format_date, weekday};
use crate::contract::elaborate::nearest;
use crate::contract::machines::non_negative;
use crate::contract::scope::duplicate_statement;
use crate::contract::value::Dimension;
use linewright_core::diagnostics::codes;
use linewright_core::source::Span;
use linewright_syntax::ast::{self, LineItem};

/// Minimum duration of a shift without its breaks, and of a break, in microseconds.
const MIN_MICROSECONDS: i64 = 1_000_000;
/// Latest end of a holiday, in days from the start of a run. A run lasts 4e9 s at most, which is
/// 46,296 days; so every line works again before its end.
const LATEST_DAY: i64 = 46_000;

/// The first day of a run, and the closed days.
#[derive(Debug, Default)]
pub(super) struct Days {
    /// Weekday of the first day: 0 for Monday.
    first_weekday: u8,
    /// As in [`WorkCalendar::closed`].
    closed: Vec<(i64, i64)>,
}

impl<'a> Builder<'a, '_> {
    /// Resolves the first day of a run and the holidays of the line.
    pub(super) fn declare_days(&mut self, decl: &'a ast::Line) -> Option<i64> {
        let mut starts = decl.items.iter().filter_map(|item| match item {
            LineItem::Start(date) => Some(date),
            _ => None,
        });
        let written = starts.next();
        let start = written.and_then(|date| self.date(date));
        // The dates of later statements are checked, too.
        for date in starts {
            self.date(date);
        }
        if let Some(start) = start {
            self.days.first_weekday = weekday(start);
        }
        let mut closed = Vec::new();
        let mut is_reported = false;
        for item in &decl.items {
            let LineItem::Holiday(first_date, last_date) = item else {
                continue;
            };
            let last_date = last_date.as_ref().unwrap_or(first_date);
            let span = first_date.span.to(last_date.span);
            let first = self.date(first_date);
            let last = if last_date.span == first_date.span {
                first
            } else {
                self.date(last_date)
            };
            let (Some(first), Some(last)) = (first, last) else {
                continue;
            };
            if last < first {
                self.e.findings.error_with(
                    codes::ARGUMENT,
                    span,
                    "a holiday must not end before it begins",
                    format!(
                        "exchange the dates: `holiday {} to {}`",
                        last_date.text, first_date.text
                    ),
                );
                continue;
            }
            match (start, written) {
                (Some(start), Some(written)) if last < start => {
                    self.e.findings.error_with(
                        codes::ARGUMENT,
                        span,
                        format!(
                            "this holiday is over when a run starts, on {}",
                            written.text
                        ),
                        "remove it, or let the run start earlier",
                    );
                }
                (Some(start), _) if last - start > LATEST_DAY => self.e.findings.error_with(
                    codes::ARGUMENT,
                    span,
                    "this holiday ends later than a run can last, so the line never works again",
                    "end it within 125 years from the start",
                ),
                (Some(start), _) => closed.push((first - start, last - start)),
                (None, None) if !is_reported => {
                    is_reported = true;
                    let monday = first - i64::from(weekday(first));
                    self.e.findings.error_with(
                        codes::ARGUMENT,
                        span,
                        "a line with a holiday needs the date of its first day",
                        format!("add it, for instance `start {}`", format_date(monday)),
                    );
                }
                _ => {}
            }
        }
        closed.sort_unstable();
        for (first, last) in closed {
            match self.days.closed.last_mut() {
                Some(before) if first <= before.1 + 1 => before.1 = before.1.max(last),
                _ => self.days.closed.push((first, last)),
            }
        }
        start
    }

    /// Resolves the calendar of the line. A line with holidays but without shifts works around the
    /// clock on all other days.
    pub(super) fn line_calendar(&mut self, decl: &'a ast::Line) -> Option<WorkCalendar> {
        let shifts: Vec<&ast::Shift> = decl
            .items
            .iter()
            .filter_map(|item| match item {
                LineItem::Shift(shift) => Some(shift),
                _ => None,
            })
            .collect();
        if shifts.is_empty() && !self.days.closed.is_empty() {
            let all_day = Shift::daily(0.0, WorkCalendar::DAY);
            return Some(self.with_days(vec![all_day]));
        }
        self.calendar(&shifts)
    }

    /// Resolves the calendar of these shifts. `None` if there are none, or if they are wrong.
    pub(super) fn calendar(&mut self, shifts: &[&'a ast::Shift]) -> Option<WorkCalendar> {
        let resolved: Vec<_> = shifts.iter().map(|shift| self.shift(shift)).collect();
        let resolved: Option<Vec<Shift>> = resolved.into_iter().collect();
        let shifts = resolved.filter(|shifts| !shifts.is_empty())?;
        Some(self.with_days(shifts))
    }

    /// A calendar of these shifts with the days of the line.
    fn with_days(&self, shifts: Vec<Shift>) -> WorkCalendar {
        WorkCalendar {
            first_weekday: self.days.first_weekday,
            shifts,
            closed: self.days.closed.clone(),
        }
    }

    fn shift(&mut self, shift: &'a ast::Shift) -> Option<Shift> {
        let hours = self.hours(&shift.hours, "shift", "`shift 0 h to 24 h` is a whole day");
        let days = self.weekdays(&shift.days);
        let breaks: Vec<_> = shift
            .breaks
            .iter()
            .map(|hours| (hours.span, self.hours(hours, "break", "remove it")))
            .collect();
        let (from, to) = hours?;
        if from == WorkCalendar::DAY_MICROSECONDS {
            self.e.findings.error_with(
                codes::ARGUMENT,
                shift.hours.from.span,
                "a shift begins before 24 h",
                "write `0 h` for the start of a day",
            );
            return None;
        }
        let mut resolved = Shift {
            from,
            to: after(from, to),
            days: days?,
            breaks: Vec::new(),
            finishes_work: shift.finish_work,
        };
        if resolved.to - from < MIN_MICROSECONDS {
            self.e.findings.error_with(
                codes::ARGUMENT,
                shift.hours.span,
                "a shift must last at least one second",
                "write hours after midnight: `shift 6 h to 14 h`",
            );
            return None;
        }
        let mut is_sound = true;
        for (span, hours) in breaks {
            let Some((start, end)) = hours else {
                is_sound = false;
                continue;
            };
            // Over midnight, the times after midnight are those of the next day.
            let start = if start < from {
                start + WorkCalendar::DAY_MICROSECONDS
            } else {
                start
            };
            let end = after(start, end);
            let problem = if end <= start || end > resolved.to {
                "this break is not within the shift"
            } else if end - start < MIN_MICROSECONDS {
                "a break must last at least one second"
            } else {
                resolved.breaks.push((start, end));
                continue;
            };
            is_sound = false;
            self.e.findings.error_with(
                codes::ARGUMENT,
                span,
                problem,
                "a break begins and ends within its shift: `shift 6 h to 14 h break 9 h to 9.25 h`",
            );
        }
        if !is_sound {
            return None;
        }
        if resolved.working_microseconds() < MIN_MICROSECONDS {
            self.e.findings.error_with(
                codes::ARGUMENT,
                shift.hours.span,
                "the breaks of this shift leave no time to work",
                "shorten the breaks, or remove the shift",
            );
            return None;
        }
        Some(resolved)
    }

    /// Resolves two times of day, in microseconds. The second may be smaller: it is on the next day
    /// then.
    fn hours(&mut self, hours: &'a ast::Hours, what: &str, help: &str) -> Option<(i64, i64)> {
        let from = self.time_of_day(&hours.from);
        let to = self.time_of_day(&hours.to);
        let (from, to) = (from?, to?);
        if from == to {
            self.e.findings.error_with(
                codes::ARGUMENT,
                hours.span,
                format!("this {what} has no length"),
                help,
            );
            return None;
        }
        Some((from, to))
    }

    fn time_of_day(&mut self, time: &'a ast::Expr) -> Option<i64> {
        let seconds = non_negative(&mut self.e, time, Dimension::Time)?;
        if seconds > WorkCalendar::DAY {
            self.e.findings.error_with(
                codes::ARGUMENT,
                time.span,
                "a time of day is at most 24 h",
                "write hours after midnight; a shift over midnight is `shift 22 h to 6 h`",
            );
            return None;
        }
        Some(microseconds(seconds))
    }

    /// Resolves weekdays; all of them if none is given.
    fn weekdays(&mut self, written: &'a [ast::Days]) -> Option<[bool; 7]> {
        if written.is_empty() {
            return Some([true; 7]);
        }
        let mut days: [Option<Span>; 7] = [None; 7];
        let mut is_known = true;
        for range in written {
            let first = self.weekday(&range.first);
            let last = match &range.last {
                Some(last) => self.weekday(last),
                None => first,
            };
            let (Some(first), Some(last)) = (first, last) else {
                is_known = false;
                continue;
            };
            let count = (last + 7 - first) % 7 + 1;
            let mut twice = None;
            for day in (first..first + count).map(|day| day % 7) {
                match days[day] {
                    Some(earlier) => twice = twice.or(Some((day, earlier))),
                    None => days[day] = Some(range.span()),
                }
            }
            if let Some((day, earlier)) = twice {
                self.e.findings.push(duplicate_statement(
                    WEEKDAYS[day],
                    range.span(),
                    earlier,
                    "name each day once",
                ));
            }
        }
        is_known.then(|| days.map(|day| day.is_some()))
    }

    fn weekday(&mut self, name: &ast::Name) -> Option<usize> {
        let found = WEEKDAYS.iter().position(|day| *day == name.text);
        if found.is_none() {
            let short = name.text.to_lowercase();
            let mut days = WEEKDAYS.into_iter();
            let meant = days
                .find(|day| short.len() > 1 && day.to_lowercase().starts_with(&short))
                .or_else(|| nearest(&name.text, WEEKDAYS.into_iter()));
            let all = format!("the weekdays are {}", WEEKDAYS.join(", "));
            self.e.findings.error_with(
                codes::NAME_UNKNOWN,
                name.span,
                format!("there is no weekday `{}`", name.text),
                match meant {
                    Some(meant) => format!("did you mean `{meant}`? {all}"),
                    None => all,
                },
            );
        }
        found
    }

    /// Resolves a date to the number of days since 1970-01-01.
    fn date(&mut self, date: &ast::Name) -> Option<i64> {
        let parts: Vec<&str> = date.text.split('-').collect();
        let number = |part: &str| part.parse::<u32>().ok();
        let [Some(year), Some(month), Some(day)] =
            [0, 1, 2].map(|i| parts.get(i).and_then(|part| number(part)))
        else {
            self.refuse_date(date, "a year has four digits");
            return None;
        };
        let wrong = if parts[0].len() != 4 || year == 0 {
            "a year has four digits".to_owned()
        } else if !(1..=12).contains(&month) {
            format!("there is no month {month}")
        } else if day == 0 || day > days_in_month(year, month) {
            let last = days_in_month(year, month);
            format!("this month has the days 1 to {last}")
        } else if parts[1].len() != 2 || parts[2].len() != 2 {
            format!("write `{year:04}-{month:02}-{day:02}`")
        } else {
            return Some(days_since_1970(year, month, day));
        };
        self.refuse_date(date, &wrong);
        None
    }

    fn refuse_date(&mut self, date: &ast::Name, why: &str) {
        self.e.findings.error_about(
            codes::ARGUMENT,
            date,
            "is not a date",
            format!("{why}; a date is written year-month-day, such as `2026-12-24`"),
        );
    }
}
