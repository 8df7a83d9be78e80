//! stub
/// c
pub const RUSTC: &str = "rustc";
/// s
pub struct StageCode;
impl StageCode { /// f
 pub fn fingerprint(&self) -> [u8;32] { [0;32] } }
/// o
pub fn of(_: &str) -> Option<&'static StageCode> { None }
