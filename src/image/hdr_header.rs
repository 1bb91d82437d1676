//! Headers of Radiance HDR files as programs write them.

use super::hdr_flat::{coded_rows, is_flat};

/// What a header says, and where the picture behind it begins.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HdrHeader {
    /// Factor that was applied to the radiance of each channel: EXPOSURE and COLORCORR, multiplied where they stand
    /// several times.
    pub exposure: [f32; 3],
    /// Red, green, blue and white in CIE xy, if the file has them.
    pub primaries: Option<[[f32; 2]; 4]>,
    /// Whether the first row of the file is the lowest of the picture.
    pub bottom_up: bool,
    /// What else it says of its pixels, which is not followed, in words.
    pub unheeded: Vec<String>,
    /// Pixels.
    width: u32,
    height: u32,
    /// Offset of the first byte of the picture.
    start: usize,
}

impl HdrHeader {
    /// Width and height, pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.width as usize, self.height as usize]
    }

    /// Reads the header of a file, whatever ends its lines and whatever follows `#?`.
    ///
    /// # Errors
    /// A sentence, where the header does not end, or the picture is in XYZ or does not lie in rows.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut header = Self {
            exposure: [1.0; 3],
            primaries: None,
            bottom_up: false,
            unheeded: Vec::new(),
            width: 0,
            height: 0,
            start: 0,
        };
        loop {
            let line = header.line(bytes)?;
            if line.is_empty() {
                break;
            }
            let Some((name, value)) = line.split_once('=') else {
                continue;
            };
            match name.trim() {
                "FORMAT" if value.trim() != "32-bit_rle_rgbe" => {
                    let format = value.trim();
                    return Err(format!("FORMAT is {format}: save it as 32-bit_rle_rgbe"));
                }
                name @ ("EXPOSURE" | "COLORCORR") => header.multiply(name, value)?,
                name @ ("GAMMA" | "PIXASPECT") if value.trim().parse() != Ok(1.0_f32) => {
                    let value = value.trim();
                    let note =
                        format!("its {name}={value} is left out: values are linear, pixels square");
                    header.unheeded.push(note);
                }
                "PRIMARIES" => header.primaries = primaries(value)?,
                _ => {}
            }
        }
        let line = header.line(bytes)?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let size = match words[..] {
            [y @ ("-Y" | "+Y"), height, "+X", width] => {
                header.bottom_up = y == "+Y";
                height.parse().ok().zip(width.parse().ok())
            }
            _ => None,
        };
        (header.height, header.width) = size.ok_or_else(|| {
            format!("`{line}` was found where a size like `-Y 480 +X 640` is expected")
        })?;
        // The colour of a row, if all of its pixels are equal.
        let least = 4 * header.height as usize;
        if bytes.len() - header.start < least {
            let found = bytes.len() - header.start;
            return Err(format!(
                "{found} bytes follow the header where {least} are the least for `{line}`: the file is cut short"
            ));
        }
        Ok(header)
    }

    /// The file with a header that says nothing but the size, and rows that the decoder takes for what they are.
    pub fn plain(&self, bytes: &[u8]) -> Vec<u8> {
        let (width, height) = (self.width, self.height);
        let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
        let [width, height] = self.size();
        let pixels = &bytes[self.start..];
        match is_flat(width) {
            true => [head.as_bytes(), &coded_rows(pixels, width, height)].concat(),
            false => [head.as_bytes(), pixels].concat(),
        }
    }

    /// The next line, without what ends it.
    fn line(&mut self, bytes: &[u8]) -> Result<String, String> {
        let rest = &bytes[self.start..];
        let end = rest.iter().position(|&byte| byte == b'\n');
        let end = end.ok_or("the header has no end")?;
        self.start += end + 1;
        let line = rest[..end].strip_suffix(b"\r").unwrap_or(&rest[..end]);
        Ok(String::from_utf8_lossy(line).into_owned())
    }

    fn multiply(&mut self, name: &str, value: &str) -> Result<(), String> {
        let numbers: Vec<f32> = value
            .split_whitespace()
            .filter_map(|word| word.parse().ok())
            .collect();
        let factors = match numbers[..] {
            [all] => [all; 3],
            [r, g, b] => [r, g, b],
            _ => [0.0; 3],
        };
        if !factors.iter().all(|f| f.is_finite() && *f > 0.0) {
            return Err(format!("{name}={value} is not a factor above 0"));
        }
        (0..3).for_each(|c| self.exposure[c] *= factors[c]);
        Ok(())
    }
}

/// Eight numbers: x and y of red, green, blue and white. Photoshop writes zeros where it knows none.
fn primaries(value: &str) -> Result<Option<[[f32; 2]; 4]>, String> {
    let words = value.split_whitespace().map(str::parse::<f32>);
    let numbers: Vec<f32> = words.filter_map(Result::ok).collect();
    match numbers[..] {
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] => Ok(None),
        [rx, ry, gx, gy, bx, by, wx, wy] => Ok(Some([[rx, ry], [gx, gy], [bx, by], [wx, wy]])),
        _ => Err(format!("PRIMARIES={value} are not eight numbers")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_all_programs_are_read() {
        for (text, exposure, bottom_up) in [
            (
                "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 3\nxyxyxyxy",
                [1.0; 3],
                false,
            ),
            (
                "#?RGBE\r\nGAMMA=1\r\n\r\n-Y 2 +X 3\r\nxyxyxyxy",
                [1.0; 3],
                false,
            ),
            (
                "#?RADIANCE\n# made by hand\nEXPOSURE= 2\nEXPOSURE=0.25\nCOLORCORR=1 2 4\n\n+Y 2 +X 3\nxyxyxyxy",
                [0.5, 1.0, 2.0],
                true,
            ),
        ] {
            let header = HdrHeader::read(text.as_bytes()).unwrap();
            assert_eq!((header.exposure, header.bottom_up), (exposure, bottom_up));
            assert_eq!((header.width, header.height), (3, 2));
            assert!(header.unheeded.is_empty());
            let plain = header.plain(text.as_bytes());
            assert!(plain.starts_with(b"#?RADIANCE\n") && plain.ends_with(b"+X 3\nxyxyxyxy"));
        }
    }

    #[test]
    fn what_is_not_followed_is_told() {
        let text = "#?RADIANCE\nGAMMA=2.2\nPIXASPECT= 1.0\nPIXASPECT=2\n\n-Y 1 +X 1\nxyxy";
        let told = HdrHeader::read(text.as_bytes()).unwrap().unheeded;
        assert!(told.len() == 2 && told[0].contains("GAMMA=2.2"), "{told:?}");
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        for (text, expected) in [
            ("#?RADIANCE\n", "no end"),
            ("#?RADIANCE\n\n+X 3 -Y 2\n", "`+X 3 -Y 2`"),
            ("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 3\n", "xyze"),
            ("#?RADIANCE\n\n-Y 30000 +X 30000\nxy", "cut short"),
            ("#?RADIANCE\nEXPOSURE=0\n\n-Y 2 +X 3\n", "EXPOSURE=0"),
            (
                "#?RADIANCE\nPRIMARIES=1 0\n\n-Y 2 +X 3\n",
                "PRIMARIES=1 0 are not eight",
            ),
        ] {
            let error = HdrHeader::read(text.as_bytes()).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
