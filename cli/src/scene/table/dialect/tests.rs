//! Tables as people have them, each read from its bytes.

use super::*;

const FIRST_TWO: [Column<'_>; 2] = [Column::Number(0), Column::Number(1)];

/// The numbers of these columns, with the lines of the rows, or the message and the line of the first fault.
fn read(bytes: &[u8], columns: &[Column<'_>; 2]) -> Result<Vec<(Vec<f64>, usize)>, (String, usize)> {
    let (text, _) = decode(bytes).expect("a text");
    let line = |span: &Span| text[..span.start].matches('\n').count() + 1;
    let told = |wrong: &RowFault| (wrong.message.clone(), wrong.span.as_ref().map_or(0, line));
    let sheet = Sheet::new(&text).map_err(|wrong| told(&wrong))?;
    let rows = sheet.rows(columns, 0, "").map_err(|wrong| told(&wrong[0]))?;
    Ok(rows.rows.iter().map(|(row, span)| (row.clone(), line(span))).collect())
}

#[track_caller]
fn is(text: &str, expected: [[f64; 2]; 2], first_line: usize) {
    let found = read(text.as_bytes(), &FIRST_TWO);
    let expected = expected.iter().zip(first_line..).map(|(row, line)| (row.to_vec(), line)).collect();
    assert_eq!(found, Ok(expected), "{text:?}");
}

#[track_caller]
fn refused(text: &str, line: usize, parts: &[&str]) {
    let (message, place) = read(text.as_bytes(), &FIRST_TWO).expect_err(text);
    assert!(place == line && parts.iter().all(|part| message.contains(part)), "{text:?}: {message} in line {place}");
}

#[test]
fn separators_and_decimal_marks() {
    let rows = [[0.0, 0.5], [10.0, -1.25]];
    for text in [
        "0;0.5\n10;-1.25",
        "0,0;0,5\r\n10,0;-1,25\r\n",
        "0\t0.5\n10\t-1.25\n",
        "0,0000\t0,5000\n10,0000\t-1,2500",
        " 0   0.5\n10  -1.25\n",
        "0,0 0,5\n10,0 -1,25",
        "0, 0.5\n10, -1.25",
        "0,0.5\n10,-1.25",
        "0 , 5e-1 , 7\n10 , -1.25 , 8",
        "0,0 0,5 // point 0\n10,0 -1,25 // point 1; the last\n",
        "0;0.5 # a, b\n10;-1.25",
        "0;0.5;\n10;-1.25;;\n",
        "0 0.5;\n10 -1.25;\n",
        "0,0.5\n10,-1.25,\n",
        "0;0.5\r10;-1.25\r",
        "\"0\";\"0,5\"\n\"10\";\"-1,25\"\n",
        "\"0\",\"0,5\"\n\"10\",\"-1,25\"\n",
        "0;\u{2212}\u{2212}\n0;0.5\n10;\u{2212}1.25".split_once('\n').unwrap().1,
        "0;.5;x\n1.0e1;-1,25e0;x".replace(".5", ",5").replace("1.0e1", "10").as_str(),
    ] {
        is(text, rows, 1);
    }
    is("0,5\n10,7", [[0.0, 5.0], [10.0, 7.0]], 1);
    is("0;0,5\n10.0;-1.25", rows, 1);
}

#[test]
fn headings_comments_counts_and_separators_may_come_first() {
    let rows = [[0.0, 0.5], [10.0, -1.25]];
    for (text, line) in [
        ("Angle;Lift\n[deg];[mm]\n0;0.5\n10;-1.25", 3),
        ("Cam 3 of 5, measured\n# 12 points\n\n// 7 8\n% 1;2\nphi\tU\n0\t0.5\n10\t-1.25", 7),
        ("sep=;\n0;0,5\n10;-1,25", 2),
        ("sep=,\n0,0.5\n10,-1.25", 2),
        ("SEP=\t\n0\t0.5\n10\t-1.25", 2),
        ("sep= \n0 0.5\n10 -1.25", 2),
        ("\"sep=;\"\n0;0,5\n10;-1,25", 2),
        ("2\n0 0.5\n10 -1.25", 2),
        ("\u{feff}phi;U\n2\n0;0.5\n10;-1.25", 3),
        ("12.03.2026;14:05;3\n1. Versuch\n0;0,5\n10;-1,25\n;;\n", 3),
        ("Crank angle [deg],Lift [%],Opens\n0,0.5,690\n10,-1.25,", 2),
    ] {
        is(text, rows, line);
    }
    refused("3\n0 0.5\n10 -1.25", 1, &["number alone", "number of the rows, 2"]);
    let text = "Points;36\n0;0.5\n10;-1.25";
    is(text, rows, 2);
    let doubtful = Sheet::new(text).unwrap().rows(&FIRST_TWO, 0, "").unwrap().doubtful;
    assert_eq!(doubtful.iter().map(|line| (line.start, line.end)).collect::<Vec<_>>(), [(0, 9)]);
}

#[test]
fn what_can_be_read_two_ways_is_refused_with_both() {
    let both = ["two ways", "0 | 0000 | 0 | 0760", "0.0000 | 0.0760"];
    refused("0,0000,0,0760\n1,0000,0,3015", 1, &both);
    refused("phi,U\n0,0,000\n1,0,076\n", 2, &["0 | 0 | 000", "0 | 0.000"]);
    // Rows of different lengths, as where whole numbers lose their decimals.
    refused("0,0\n0,5,0,2\n1,0,4", 2, &["0 | 5 | 0 | 2", "0.5 | 0.2"]);
    for text in ["sep=,\n0,1,2,3\n1,2,3,4", "x,y,v,a\n0,1,2,3\n1,2,3,4", "0, 1, 2, 3\n1, 2, 3, 4"] {
        assert!(read(text.as_bytes(), &FIRST_TWO).is_ok(), "{text}");
    }
    // Commas of thousands beside decimal points, blanks behind some of the commas, a title with as many.
    refused("phi,s\n0,1,300.0\n3,1,304.5", 2, &["0 | 1 | 300.0", "commas of thousands as 0 | 1300.0"]);
    refused("0,0, 0,000\n1,5, 0,107", 1, &["0 | 0 | 0 | 000", "0.0 | 0.000"]);
    refused(
        "Kurve A, Abtrieb links, Messung im Mai, Maier\n0,0,2,000\n3,0,2,223",
        2,
        &["0 | 0 | 2 | 000", "0.0 | 2.000"],
    );
    // What is missing in a row, or one more, moves its cells.
    refused("45,999.0\n48,1,006.0\n51,998.0", 2, &["48 | 1 | 006.0", "48 | 1006.0"]);
    refused("45,999.0\n48,1,06.0\n51,998.0", 2, &["this line has 3 cells, most have 2"]);
    refused("phi lift vel\n0 1 2\n3 40\n6 1 2", 3, &["this line has 2 cells, most have 3"]);
    refused("0\u{a0}1\n48\u{a0}1\u{a0}006.0\n51 1", 2, &["this line has 3 cells"]);
    // Thousands or decimals.
    refused("0,\"500\"\n3,\"1,200\"", 2, &["1,200 may be 1.200 or 1200"]);
    refused("0\t1,500\n3\t1,200", 1, &["1,500 may be 1.500 or 1500"]);
    refused("0;990\n3;1.010", 2, &["1.010 may be 1.010 or 1010"]);
    assert_eq!(read(b"0;16.123\n3;17.123", &FIRST_TWO).unwrap()[1].0, [3.0, 17.123]);
    assert_eq!(read(b"0;0,500\n3;17,123", &FIRST_TWO).unwrap()[1].0, [3.0, 17.123]);
    assert_eq!(read(b"0;0\n3;1.010\n6;0.5", &FIRST_TWO).unwrap()[1].0, [3.0, 1.01]);
    refused("0;0.5\n10;1,234\n20;7", 2, &["1,234 may be 1.234 or 1234"]);
    refused("0 0,5\n10 1.234,5", 2, &["\"1.234,5\" is not"]);
    refused("0;1,234,567\n10;5", 1, &["\"1,234,567\" is not"]);
}

#[test]
fn wrong_rows_are_never_taken_for_headings() {
    refused("phi;U\n0;O.5\n10;1", 2, &["\"O.5\" is not a finite number"]);
    refused("0;0\n10;\n20;1", 2, &["column 2 is missing: this line has 1"]);
    refused("0;0\nten;1\n20;1", 2, &["\"ten\""]);
    refused("0;nan\n10;1", 1, &["\"nan\""]);
    refused("0 deg;1 mm\n10 deg;2 mm", 1, &["\"0 deg\""]);
    refused("one;1\ntwo;2", 1, &["\"one\""]);
    refused("0;\n10;1\n20;2", 1, &["column 2 is missing"]);
    refused("", 0, &["no row with numbers"]);
    refused("phi;U\n#0;1\n", 0, &["no row with numbers"]);
    refused("0;1\n10;#N/A\n20;2", 2, &["\"#N/A\" is not a finite number"]);
    // Behind the last row, too; words end a table.
    refused("0;0\n10;1\n2O;1", 3, &["\"2O\""]);
    refused("0;0\n10;1\nnan;nan", 3, &["\"nan\""]);
    refused("0;0\n10;1\n-;1", 3, &["\"-\""]);
    refused("0;0\n10;1\nEND\n20;1", 3, &["\"END\""]);
    assert_eq!(read(b"0;0\n10;1\nEND", &FIRST_TWO).unwrap().len(), 2);
}

#[test]
fn columns_are_found_by_their_heading() {
    let text = "Lift;x;Angle\n[mm];;[deg]\n0,5;;0\n-1,25;;10";
    let named = |columns: [&'static str; 2]| read(text.as_bytes(), &columns.map(Column::Heading));
    assert_eq!(named(["Angle", "Lift"]), Ok(vec![(vec![0.0, 0.5], 3), (vec![10.0, -1.25], 4)]));
    assert_eq!(named(["[deg]", "Lift"]), named(["Angle", "Lift"]));
    assert_eq!(named(["phi", "Lift"]), Err(("there is no column \"phi\"".to_owned(), 1)));
    assert_eq!(named(["Lift", "Lift"]), Err(("column 1 is used twice".to_owned(), 0)));
    let twice = read(b"U;phi;U\n0;1;2", &[Column::Heading("phi"), Column::Heading("U")]);
    assert_eq!(twice, Err(("two columns have the heading \"U\"".to_owned(), 1)));
    let words = read(b"point,X,Y\nP1,0,0.5\nP2,10,-1.25", &[Column::Number(1), Column::Number(2)]);
    assert_eq!(words, Ok(vec![(vec![0.0, 0.5], 2), (vec![10.0, -1.25], 3)]));
    // As numpy.savetxt writes it.
    let found = read(b"# U phi\n0.5 0\n-1.25 10", &[Column::Heading("phi"), Column::Heading("U")]);
    assert_eq!(found, Ok(vec![(vec![0.0, 0.5], 2), (vec![10.0, -1.25], 3)]));
    let of = |text: &str| Sheet::new(text).unwrap().rows(&FIRST_TWO, 3, "").map(|rows| rows.columns.len());
    assert_eq!(
        (of("X;Y;V;A\n0;1;2;3").ok(), of("0;1;2;3").ok(), of("X;Y;V;A;B\n0;1;2;3;4").ok()),
        (Some(4), Some(4), Some(5))
    );
    assert!(of("phi;U;dU;ddU_before\n0;1;2;3").is_err());
    let sheet = Sheet::new("# probe 3 mm\nCam;probe 3 mm\nphi [deg] s (mm)\n0;1").unwrap();
    assert_eq!(sheet.headings(1).collect::<Vec<_>>(), ["probe 3 mm"]);
    let sheet = Sheet::new("phi [deg] s (mm)\n0 1.25\n1 2").unwrap();
    assert_eq!(sheet.headings(1).collect::<Vec<_>>(), ["s (mm)"]);
    let sheet = Sheet::new("X [deg];Y [mm];V (mm/deg)\n0;1.25;2").unwrap();
    assert_eq!((sheet.unit(2).map(|unit| unit.1), sheet.unit(7)), (Some("mm/deg".to_owned()), None));
    assert!((sheet.rows(&FIRST_TWO, 0, "").unwrap().digits[1] - 0.01).abs() < 1e-17);
}

#[test]
fn bytes_of_any_encoding() {
    let text = "Höhe;\u{2212}1\n0;1\n";
    let utf16 = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
    let (little, big) = (utf16(u16::to_le_bytes), utf16(u16::to_be_bytes));
    let marked = |mark: [u8; 2], bytes: &[u8]| [&mark, bytes].concat();
    for bytes in [
        text.as_bytes().to_vec(),
        ["\u{feff}", text].concat().into_bytes(),
        marked([0xff, 0xfe], &little),
        marked([0xfe, 0xff], &big),
    ] {
        assert_eq!(decode(&bytes), Some((text.to_owned(), None)));
    }
    let plain: Vec<u8> = "0;1\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(decode(&plain), Some(("0;1\n".to_owned(), None)));
    let (latin, note) = decode(b"H\xf6he;Winkel [\xb0]\n0;1\n").unwrap();
    assert!(latin.starts_with("Höhe;Winkel [°]\n") && note.unwrap().contains("Latin-1"));
    assert_eq!(decode(b"PK\x03\x04\0\0"), None);
}
