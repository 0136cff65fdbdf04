use super::*;
use serde_json::json;

/// All that archives can hold.
#[derive(Debug, Clone, Default, PartialEq)]
struct State {
    numbers: Vec<f64>,
    rows: Vec<[f64; 3]>,
    indices: Vec<u32>,
    fixed: [u64; 2],
    limit: f64,
    switches: Vec<[bool; 3]>,
    step: usize,
    begun: bool,
    names: Vec<String>,
}

impl State {
    fn sample() -> Self {
        Self {
            numbers: vec![0.1 + 0.2, -0.0, f64::MIN_POSITIVE / 8.0, f64::from_bits(0x7ff8_dead_beef_0001)],
            rows: vec![[1.0, 2.0, 3.0], [f64::NEG_INFINITY, 5.0, 6.0]],
            indices: vec![7, u32::MAX, 9],
            fixed: [u64::MAX, 2],
            limit: f64::INFINITY,
            switches: vec![[true, false, true]],
            step: 12,
            begun: true,
            names: vec!["a \"b\"".into(), String::new()],
        }
    }

    fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.section("part", |archive| {
            archive.column("numbers", &mut self.numbers)?;
            archive.section("below", |archive| archive.column("rows", &mut self.rows))?;
            archive.column("indices", &mut self.indices)
        })?;
        archive.slice("fixed", &mut self.fixed)?;
        archive.number("limit", &mut self.limit)?;
        archive.switches("switches", &mut self.switches)?;
        archive.count("step", &mut self.step)?;
        archive.flag("begun", &mut self.begun)?;
        archive.texts("names", &mut self.names)
    }

    fn bits(&self) -> Vec<u64> {
        self.numbers.iter().chain(self.rows.as_flattened()).chain([&self.limit]).map(|x| x.to_bits()).collect()
    }
}

fn written(folder: &Path) -> PathBuf {
    let path = folder.join("a.checkpoint");
    let head = json!({"step": 3}).as_object().unwrap().clone();
    let mut state = State::sample();
    let bytes = file::write(&path, head, &mut |archive| state.exchange(archive)).unwrap();
    assert_eq!(std::fs::metadata(&path).unwrap().len(), bytes);
    path
}

#[test]
fn a_state_comes_back_with_all_its_bits() {
    let folder = tempfile::tempdir().unwrap();
    let contents = file::read(&written(folder.path())).unwrap();
    assert_eq!(contents.head["step"], 3);
    let mut state = State { numbers: vec![1.0; 9], ..State::default() };
    state.exchange(&mut Archive::loading(&contents)).unwrap();
    let sample = State::sample();
    assert_eq!(state.bits(), sample.bits());
    assert_eq!((&state.indices, state.fixed, &state.names), (&sample.indices, sample.fixed, &sample.names));
    assert_eq!((state.switches, state.step, state.begun), (sample.switches, 12, true));
}

/// As a reader without this program would find them: by header, type, shape and offset.
#[test]
fn the_columns_stand_where_the_header_says() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = std::fs::read(written(folder.path())).unwrap();
    let length = u64::from_le_bytes(bytes[8..16].try_into().unwrap()) as usize;
    let header: Value = serde_json::from_slice(&bytes[16..16 + length]).unwrap();
    let data = 16 + length;
    assert_eq!(data % 8, 0);
    let columns = header["columns"].as_array().unwrap();
    let rows = columns.iter().find(|column| column["name"] == "part/below/rows").unwrap();
    assert_eq!((rows["shape"].clone(), rows["type"].as_str()), (json!([2, 3]), Some("<f8")));
    let at = data + rows["offset"].as_u64().unwrap() as usize;
    assert_eq!(f64::from_le_bytes(bytes[at + 8..at + 16].try_into().unwrap()), 2.0);
}

#[test]
fn every_changed_or_missing_byte_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let whole = std::fs::read(&path).unwrap();
    for length in 0..whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(matches!(file::read(&path), Err(CheckpointError::Damaged { .. })), "cut off at {length}");
    }
    for place in 0..whole.len() {
        let mut changed = whole.clone();
        changed[place] ^= 0x10;
        std::fs::write(&path, &changed).unwrap();
        assert!(matches!(file::read(&path), Err(CheckpointError::Damaged { .. })), "changed at {place}");
    }
}

#[test]
fn what_does_not_fit_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let contents = file::read(&written(folder.path())).unwrap();
    let mut archive = Archive::loading(&contents);
    let told = |result: Result<(), CheckpointError>| result.unwrap_err().to_string();
    let missing = told(archive.column("part/other", &mut Vec::<f64>::new()));
    assert!(missing.contains("part/other"), "{missing}");
    let longer = told(archive.slice("fixed", &mut [0u64; 3]));
    assert!(longer.contains("2 × 1") && longer.contains("3 × 1"), "{longer}");
    let other = told(archive.column("part/indices", &mut Vec::<f64>::new()));
    assert!(other.contains("u4") && other.contains("f8"), "{other}");
    assert!(told(archive.count("begun", &mut 0)).contains("begun"));
}

#[test]
fn growing_files_go_on_where_they_stood() {
    let folder = tempfile::tempdir().unwrap();
    let (path, table) = (folder.path().join("a.checkpoint"), folder.path().join("table.csv"));
    let mut file = Some(File::create(&table).unwrap());
    file.as_mut().unwrap().write_all(b"one\n").unwrap();
    file::write(&path, Map::new(), &mut |archive| archive.growing_file("table", &table, &mut file)).unwrap();
    file.as_mut().unwrap().write_all(b"to be forgotten\n").unwrap();
    drop(file);
    let contents = file::read(&path).unwrap();
    let mut again = None;
    Archive::loading(&contents).growing_file("table", &table, &mut again).unwrap();
    again.unwrap().write_all(b"two\n").unwrap();
    assert_eq!(std::fs::read(&table).unwrap(), b"one\ntwo\n");
    std::fs::write(&table, "on").unwrap();
    let error = Archive::loading(&contents).growing_file("table", &table, &mut None).unwrap_err().to_string();
    assert!(error.contains("holds 2 bytes, but held 4"), "{error}");
}
