//! Claims about the report: verdicts follow from the data, the page needs nothing but the files beside it.

mod claims;
mod finding;
mod page;
