use super::*;

fn frame(frame: u32, viewer: u16, rmse: f64) -> FrameRecord {
    FrameRecord {
        frame,
        viewer,
        metrics: Some(Metrics {
            rmse,
            flip_ldr: rmse,
            ..Metrics::default()
        }),
        reference_floor: Some(0.3),
        rays: 10,
        bytes_cache: 100,
        bytes_work: u64::from(frame),
        stages: vec![StageRecord {
            name: "rendering".into(),
            wall: 0.5,
            cpu: 1.0,
            serial: 0.25,
        }],
        found: vec![("passes".into(), f64::from(frame))],
        notes: vec!["a note".into()],
        ..FrameRecord::default()
    }
}

#[test]
fn one_frame_is_its_own_row_to_the_bit() {
    let value = 0.123_456_789_012_345_6;
    let mut row = Row::default();
    row.sum_up(&[frame(3, 0, value)]);
    assert_eq!((row.rmse, row.flip_ldr), (Some(value), Some(value)));
    assert_eq!((row.rmse_worst, row.flicker), (Some(value), None));
    assert_eq!(row.reference_floor, Some(0.3));
}

#[test]
fn errors_are_averaged_over_measured_frames_and_costs_added_over_all() {
    let warm_up = FrameRecord {
        metrics: None,
        reference_floor: None,
        ..frame(0, 0, 9.0)
    };
    let mut later = frame(2, 0, 4.0);
    later.error_change = Some(4.0);
    later.search = Some(SearchRecord {
        seconds: 7.0,
        cpu: 9.0,
        rays: 70,
        ..SearchRecord::default()
    });
    let frames = [warm_up, frame(1, 0, 3.0), frame(1, 1, 5.0), later];
    let mut row = Row {
        caches: Some(0),
        ..Row::default()
    };
    row.sum_up(&frames);
    assert_eq!(row.rmse, Some((50.0_f64 / 3.0).sqrt()));
    assert_eq!((row.flip_ldr, row.rmse_worst), (Some(4.0), Some(5.0)));
    assert_eq!((row.flicker, row.rmse_cold), (Some(2.0), None));
    assert_eq!((row.rays, row.bytes_cache, row.bytes_work), (40, 200, 2));
    assert_eq!((row.seconds_total, row.cpu_seconds_total), (2.0, 4.0));
    let search = (&row.seconds[SEARCH_STAGE], &row.cpu_seconds[SEARCH_STAGE]);
    assert_eq!(search, (&7.0.into(), &9.0.into()));
    assert_eq!((row.search_rays, row.search_shadow_rays), (70, 0));
    assert_eq!(row.serial_share["rendering"], 0.25);
    assert_eq!(row.params["passes"], 1.0);
    assert_eq!(row.notes, ["a note"]);
}

#[test]
fn the_csv_has_a_line_for_each_frame_and_viewer() {
    let text = frames_csv(&[frame(1, 0, 3.0), frame(1, 1, 5.0)]).expect("writes");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().expect("header").clone();
    let lines: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("line")).collect();
    let cell = |line: usize, name: &str| {
        let column = header.iter().position(|h| h == name).expect(name);
        lines[line][column].to_owned()
    };
    assert_eq!(lines.len(), 2);
    assert_eq!(
        (cell(0, "rmse"), cell(1, "viewer")),
        ("3.0".into(), "1".into())
    );
    assert_eq!(
        (cell(1, "seconds_rendering"), cell(0, "lights")),
        ("0.5".into(), String::new())
    );
}
