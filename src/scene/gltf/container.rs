//! The two forms of a glTF file: plain JSON, and GLB with its chunks.

/// The parts of a file.
#[derive(Debug, PartialEq)]
pub(super) struct Container<'a> {
    pub json: &'a [u8],
    /// The binary chunk of a GLB file.
    pub binary: Option<&'a [u8]>,
}

const MAGIC: &[u8] = b"glTF";
const HEADER: usize = 12;

/// Takes a file apart. Chunks that glTF does not define are skipped, as it demands.
pub(super) fn split(bytes: &[u8]) -> Result<Container<'_>, String> {
    if !bytes.starts_with(MAGIC) {
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return Ok(Container { json, binary: None });
    }
    let word = |at: usize| {
        let four = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]) as usize)
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err("the GLB file ends within its header: is it truncated?".into());
    };
    if version != 2 {
        return Err(format!("GLB version {version} is not read, only 2"));
    }
    if length > bytes.len() {
        return Err(format!(
            "the GLB header says {length} bytes, the file has {}: is it truncated?",
            bytes.len()
        ));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = HEADER;
    while at < length {
        let (Some(size), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else {
            return Err(format!("the GLB chunk at byte {at} has no header"));
        };
        let end = (at + 8).saturating_add(size);
        let chunk = bytes.get(at + 8..end).ok_or_else(|| {
            format!("the GLB chunk at byte {at} has {size} bytes, which the file has not: is it truncated?")
        })?;
        match kind {
            b"JSON" => json = json.or(Some(chunk)),
            b"BIN\0" => binary = binary.or(Some(chunk)),
            _ => {}
        }
        at = end;
    }
    let json = json.ok_or("the GLB file has no JSON chunk")?;
    Ok(Container { json, binary })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut bytes = [MAGIC, &2_u32.to_le_bytes(), &[0; 4]].concat();
        for (kind, data) in chunks {
            bytes.extend((data.len() as u32).to_le_bytes());
            bytes.extend(*kind);
            bytes.extend(*data);
        }
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
        bytes
    }

    #[test]
    fn chunks_are_found_and_others_skipped() {
        let bytes = glb(&[(b"JSON", b"{}  "), (b"NOTE", b"?"), (b"BIN\0", b"1234")]);
        let expected = Container {
            json: b"{}  ",
            binary: Some(b"1234"),
        };
        assert_eq!(split(&bytes), Ok(expected));
        let plain = Container {
            json: b"{}",
            binary: None,
        };
        assert_eq!(split(b"\xef\xbb\xbf{}"), Ok(plain));
    }

    #[test]
    fn every_truncation_is_refused() {
        let bytes = glb(&[(b"JSON", b"{}  "), (b"BIN\0", b"1234")]);
        for length in 4..bytes.len() {
            assert!(split(&bytes[..length]).is_err(), "{length} bytes");
        }
        let mut lies = bytes.clone();
        lies[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(split(&lies).unwrap_err().contains("byte 12"));
        lies[4] = 1;
        assert!(split(&lies).unwrap_err().contains("version 1"));
        lies[4] = 2;
        lies[8..12].copy_from_slice(&5_u32.to_le_bytes());
        assert!(split(&lies).unwrap_err().contains("no JSON"));
    }
}
