//! On what machine the runs were made.

use serde_json::{Value, json};

/// Processor, cores, memory, system and program; what is not known is left out.
pub fn machine() -> Value {
    let cpu = first_of("/proc/cpuinfo", "model name");
    let memory =
        first_of("/proc/meminfo", "MemTotal").and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    let system = std::fs::read_to_string("/proc/sys/kernel/osrelease").ok();
    json!({
        "processor": cpu,
        "cores": std::thread::available_parallelism().ok().map(usize::from),
        "memory_gb": memory.map(|kilobytes| (kilobytes / 1048576.0 * 10.0).round() / 10.0),
        "system": format!("{} {} {}", std::env::consts::OS, system.unwrap_or_default().trim(), std::env::consts::ARCH),
        "bia": env!("CARGO_PKG_VERSION"),
    })
}

/// One line about it.
pub fn in_words(machine: &Value) -> String {
    let text = |key: &str| machine[key].as_str().unwrap_or("unknown").to_string();
    let number = |key: &str| machine[key].as_f64().map_or("?".to_string(), |number| number.to_string());
    format!(
        "{}, {} cores, {} GB, {}; Bia {}",
        text("processor"),
        number("cores"),
        number("memory_gb"),
        text("system"),
        text("bia")
    )
}

/// What stands behind the colon of the first line that begins so.
fn first_of(path: &str, name: &str) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    Some(line.split_once(':')?.1.trim().to_string())
}
