use super::super::dataset::tests::{integer, mixed_mesh, real};
use super::*;
use std::collections::BTreeMap;
use std::io::Read;

const RAW: VtuOptions = VtuOptions { encoding: VtuEncoding::RawAppended, compress: false, single_precision: false };

/// All combinations of the options.
fn all_options() -> Vec<VtuOptions> {
    let mut all = Vec::new();
    for encoding in [VtuEncoding::RawAppended, VtuEncoding::Base64Appended, VtuEncoding::Ascii] {
        for compress in [false, true] {
            for single_precision in [false, true] {
                all.push(VtuOptions { encoding, compress, single_precision });
            }
        }
    }
    all
}

fn file(data: &Dataset, time: Option<f64>, options: &VtuOptions) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.vtu");
    let size = write_vtu(&path, data, time, options).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(size, bytes.len() as u64);
    bytes
}

/// An array as read: VTK's name of the type, components, values.
type Read1 = (String, usize, Vec<f64>);

/// A small reader of the format, by its description and not by the writer: enough for these files.
struct Decoder<'a> {
    text: &'a str,
    appended: &'a [u8],
    base64: bool,
    compressed: bool,
}

impl<'a> Decoder<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let marker = bytes.windows(13).position(|w| w == b"<AppendedData").unwrap_or(bytes.len());
        let text = std::str::from_utf8(&bytes[..marker]).unwrap();
        let start = bytes[marker..].iter().position(|&b| b == b'_').map_or(bytes.len(), |i| marker + i + 1);
        let base64 = bytes[marker..start].windows(6).any(|w| w == b"base64");
        let compressed = text.contains("compressor=\"vtkZLibDataCompressor\"");
        Self { text, appended: &bytes[start..], base64, compressed }
    }

    /// All arrays by name.
    fn arrays(&self) -> BTreeMap<String, Read1> {
        self.text.split("<DataArray ").skip(1).map(|tag| self.array(tag)).collect()
    }

    fn array(&self, tag: &str) -> (String, Read1) {
        let get = |name: &str| Some(tag.split_once(&format!("{name}=\""))?.1.split_once('"')?.0);
        let kind = get("type").unwrap();
        let components = get("NumberOfComponents").map_or(1, |n| n.parse().unwrap());
        let values = if get("format") == Some("ascii") {
            let (_, body) = tag.split_once('>').unwrap();
            body.split('<').next().unwrap().split_whitespace().map(|word| word.parse().unwrap()).collect()
        } else {
            decode(kind, &self.bytes(get("offset").unwrap().parse().unwrap()))
        };
        (get("Name").unwrap().to_string(), (kind.to_string(), components, values))
    }

    /// `count` bytes at byte `skip` of the stream that begins at `offset`, in plain form.
    fn plain(&self, offset: usize, skip: usize, count: usize) -> Vec<u8> {
        if !self.base64 {
            return self.appended[offset + skip..offset + skip + count].to_vec();
        }
        let groups = (skip + count).div_ceil(3);
        let bytes: Vec<u8> = self.appended[offset..offset + 4 * groups].chunks(4).flat_map(base64_group).collect();
        bytes[skip..skip + count].to_vec()
    }

    fn number(&self, offset: usize, i: usize) -> usize {
        u64::from_ne_bytes(self.plain(offset, 8 * i, 8).try_into().unwrap()) as usize
    }

    fn bytes(&self, offset: usize) -> Vec<u8> {
        if !self.compressed {
            return self.plain(offset, 8, self.number(offset, 0));
        }
        let [blocks, block, last] = [0, 1, 2].map(|i| self.number(offset, i));
        let sizes: Vec<usize> = (0..blocks).map(|i| self.number(offset, 3 + i)).collect();
        let header = 8 * (3 + blocks);
        let body = offset + if self.base64 { header.div_ceil(3) * 4 } else { header };
        let (mut at, mut out) = (0, Vec::new());
        for (i, size) in sizes.into_iter().enumerate() {
            let before = out.len();
            let stream = self.plain(body, at, size);
            flate2::read::ZlibDecoder::new(stream.as_slice()).read_to_end(&mut out).unwrap();
            let partial = i + 1 == blocks && last > 0;
            assert_eq!(out.len() - before, if partial { last } else { block });
            at += size;
        }
        out
    }
}

/// One to three bytes of four characters; padding becomes zeros, which callers cut off.
fn base64_group(characters: &[u8]) -> [u8; 3] {
    let value = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        b'=' => 0,
        other => panic!("{other} is not base64"),
    };
    let bits = characters.iter().fold(0u32, |bits, &c| bits << 6 | u32::from(value(c)));
    [(bits >> 16) as u8, (bits >> 8) as u8, bits as u8]
}

fn decode(kind: &str, bytes: &[u8]) -> Vec<f64> {
    match kind {
        "Float64" => bytes.chunks(8).map(|b| f64::from_ne_bytes(b.try_into().unwrap())).collect(),
        "Float32" => bytes.chunks(4).map(|b| f32::from_ne_bytes(b.try_into().unwrap()).into()).collect(),
        "Int32" => bytes.chunks(4).map(|b| i32::from_ne_bytes(b.try_into().unwrap()).into()).collect(),
        "UInt8" => bytes.iter().map(|&b| b.into()).collect(),
        other => panic!("type {other}"),
    }
}

#[test]
fn every_encoding_gives_every_value_back() {
    let data = mixed_mesh(); // exact in single precision too
    for options in all_options() {
        let bytes = file(&data, Some(0.1), &options);
        let arrays = Decoder::new(&bytes).arrays();
        let real = if options.single_precision { "Float32" } else { "Float64" };
        let check = |name: &str, kind: &str, components: usize, values: &[f64]| {
            assert_eq!(arrays[name], (kind.to_string(), components, values.to_vec()), "{name} with {options:?}");
        };
        check("Points", real, 3, data.points.as_flattened());
        check("connectivity", "Int32", 1, &[0, 1, 4, 3, 1, 2, 4, 4, 5].map(f64::from));
        check("offsets", "Int32", 1, &[4.0, 7.0, 9.0]);
        check("types", "UInt8", 1, &[9.0, 5.0, 3.0]);
        check("TimeValue", "Float64", 1, &[0.1]);
        check("MATERIAL", "Int32", 1, &[7.0, -1.0, f64::from(i32::MAX)]);
        for Field { name, components, values } in data.point_fields.iter().chain(&data.cell_fields[1..]) {
            let FieldData::F64(values) = values else { panic!("real fields") };
            check(name, real, *components, values);
        }
    }
}

/// Lengths about the size of a block, awkward values, and one block that does not shrink.
#[test]
fn blocks_of_any_fill_are_decoded() {
    let per_block = BLOCK / 24;
    for points in [0, 1, per_block, 8 * per_block + 1, 8192, 3 * 8192] {
        let mut noise = 1u64;
        let mut next = || {
            noise = noise.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            f64::from_bits(noise >> 2 | 1 << 61) // finite, all bits of the mantissa at random
        };
        let mut data = Dataset::vertices((0..points).map(|i| [i as f64 * 0.1, -0.0, 1.0 / 3.0]).collect());
        data.point_fields = vec![real("NOISE", 1, (0..points).map(|_| next()).collect())];
        data.cell_fields = vec![integer("ID", (0..points as i32).collect())];
        for options in all_options().into_iter().filter(|o| !o.single_precision) {
            let bytes = file(&data, None, &options);
            let arrays = Decoder::new(&bytes).arrays();
            assert_eq!(arrays["Points"].2, data.points.as_flattened());
            assert_eq!(FieldData::F64(arrays["NOISE"].2.clone()), data.point_fields[0].values);
            assert!(arrays["ID"].2.iter().enumerate().all(|(i, &id)| id == i as f64));
            assert!(arrays["offsets"].2.iter().enumerate().all(|(i, &end)| end == i as f64 + 1.0));
            assert_eq!(arrays["types"].2, vec![1.0; points]);
            assert!(!arrays.contains_key("TimeValue"));
        }
    }
}

#[test]
fn the_file_does_not_depend_on_the_number_of_threads() {
    let mut data = Dataset::vertices((0..50_000).map(|i| [f64::from(i).sin(), f64::from(i % 7), 0.0]).collect());
    data.cell_fields = vec![real("X", 1, (0..50_000).map(|i| f64::from(i).cos()).collect())];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| file(&data, None, &VtuOptions::default()))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
    assert!(one.len() < file(&data, None, &RAW).len() * 3 / 4);
}

#[test]
fn text_of_special_numbers_is_what_vtk_reads() {
    let mut data = Dataset::vertices(vec![[0.0; 3]; 4]);
    data.point_fields = vec![real("X", 1, vec![f64::NAN, -f64::INFINITY, 5e-324, 0.1])];
    let options = VtuOptions { encoding: VtuEncoding::Ascii, ..RAW };
    let text = String::from_utf8(file(&data, None, &options)).unwrap();
    assert!(
        text.contains("Name=\"X\" NumberOfComponents=\"1\" format=\"ascii\">\nnan\n-inf\n0\n1e-1\n</DataArray>"),
        "{text}"
    );
    data.point_fields[0].values = FieldData::F64(vec![1e-310, 1e-40, 1e300, 0.1]);
    let single = VtuOptions { single_precision: true, ..options };
    assert!(String::from_utf8(file(&data, None, &single)).unwrap().contains(">\n0\n0\ninf\n1e-1\n</DataArray>"));
}

#[test]
fn names_are_escaped_and_faults_leave_no_file() {
    assert_eq!(escaped("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
    let folder = tempfile::tempdir().unwrap();
    let mut data = mixed_mesh();
    data.points.pop();
    let error = write_vtu(&folder.path().join("data.vtu"), &data, None, &RAW).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
