//! The tables of the source for two dwells opposite to each other, recomputed.

use super::super::printed::cubics;
use super::*;

#[test]
fn least_squares_of_the_symmetric_dwells() {
    let half = 32.0 * PI / 180.0;
    let profile = symmetric_task(3, half, Objective::LeastSquares).solve().unwrap();
    assert_odd(&profile, &[0.5747412509, -0.0763673184], 1e-10);
    let profile = symmetric_task(5, half, Objective::LeastSquares).solve().unwrap();
    assert_odd(&profile, &[0.59403855318, -0.11065943666, 0.01673302109], 1e-11);
    assert!((worst(&profile) - 3.8357152e-4).abs() < 1e-11);
}

#[test]
fn the_minimax_of_the_symmetric_dwells() {
    let half = 32.0 * PI / 180.0;
    let profile = symmetric_task(5, half, Objective::Chebyshev).solve().unwrap();
    assert_odd(&profile, &[0.59487940352, -0.11213881669, 0.01743351152], 1e-11);
    assert!((worst(&profile) - 1.74098347e-4).abs() < 1e-12);
    assert!((profile.objective - worst(&profile)).abs() < 1e-13);
}

#[test]
fn nine_harmonics_hold_a_narrow_dwell() {
    // Both in 60 digits by the normal equations and the method of Remez.
    let squares =
        [0.605661173173151, -0.134662213527249, 0.0346638913717045, -0.00619976239707465, 0.000536911379467347];
    let minimax =
        [0.605663387261311, -0.134666644552793, 0.0346670604647763, -0.00620087372288098, 0.000537070549586819];
    for (objective, expected) in [(Objective::LeastSquares, squares), (Objective::Chebyshev, minimax)] {
        let profile = symmetric_task(9, 0.05, objective).solve().unwrap();
        // The rest is the rounding of the coefficients to f64; the minimum itself is 2.4e-17.
        assert!(worst(&profile) < 4e-16, "{objective:?}: {:e}", worst(&profile));
        assert_odd(&profile, &expected, 1e-12);
    }
}

#[test]
fn nine_harmonics_hold_a_dwell_of_sixty_degrees() {
    let squares =
        [0.609892738997114, -0.143398710805582, 0.0413237981949403, -0.00877979298309472, 0.000962273886121954];
    let minimax =
        [0.610141156901097, -0.143930832007922, 0.0417606548544811, -0.00896922395349808, 0.000998714621757769];
    for (objective, expected) in [(Objective::LeastSquares, squares), (Objective::Chebyshev, minimax)] {
        let profile = symmetric_task(9, PI / 6.0, objective).solve().unwrap();
        assert_odd(&profile, &expected, 1e-12);
    }
}

#[test]
fn coefficients_of_three_to_seven_harmonics() {
    // In 60 digits by the normal equations and the method of Remez.
    let squares: [&[f64]; 3] = [
        &[0.5732889542796806, -0.07453945095361243],
        &[0.5930792474987163, -0.10902792774162806, 0.0160240155810481],
        &[0.6034889747677619, -0.12965373671384528, 0.029991413083784007, -0.0038313985451253481],
    ];
    let minimax: [&[f64]; 3] = [
        &[0.5751149867696622, -0.0770507981299834],
        &[0.5938178878142711, -0.11030342869336207, 0.016601392152999205],
        &[0.6038868186049255, -0.13043905257672537, 0.030518812622243396, -0.00397385787844796],
    ];
    for (i, order) in [3, 5, 7].into_iter().enumerate() {
        assert_odd(&symmetric_task(order, PI / 6.0, Objective::LeastSquares).solve().unwrap(), squares[i], 1e-12);
        assert_odd(&symmetric_task(order, PI / 6.0, Objective::Chebyshev).solve().unwrap(), minimax[i], 1e-12);
    }
}

/// Full width in degrees, K, coefficients of least squares and of the minimax, largest errors of the minimax and of
/// least squares, in 60 digits by the normal equations and the method of Remez.
type Row = (f64, usize, &'static [f64], &'static [f64], f64, f64);

const WIDTHS: &[Row] = &[
    (
        30.0,
        3,
        &[0.5652393530006072, -0.06531553034890447],
        &[0.5656987526628494, -0.06581141633930515],
        0.0001126636765,
        0.0002057653283,
    ),
    (
        30.0,
        5,
        &[0.5877528311219478, -0.1004208295312138, 0.01266910893392983],
        &[0.5879361220514377, -0.1007058328834326, 0.01277133813134715],
        1.627299352e-6,
        3.603802113e-6,
    ),
    (
        30.0,
        7,
        &[0.599503399442656, -0.1221006487804574, 0.02532833622577857, -0.002731103807984721],
        &[0.5996015639978973, -0.1222815581383246, 0.02543372760452816, -0.002753758143686729],
        2.467958593e-8,
        6.279453548e-8,
    ),
    (
        30.0,
        9,
        &[0.6067075022586554, -0.1367723319109795, 0.03619652041043879, -0.006749932436339144, 0.0006182419428895784],
        &[0.606768592595312, -0.1368966719212059, 0.03628851399752279, -0.006783886044363428, 0.0006234517577174772],
        3.849829065e-10,
        1.091870006e-9,
    ),
    (
        90.0,
        3,
        &[0.5861884003134506, -0.0927574239625003],
        &[0.5901186694028188, -0.1012483568503941],
        0.01112968745,
        0.0199128036,
    ),
    (
        90.0,
        5,
        &[0.6015723834236294, -0.1243874925035959, 0.02375705619007982],
        &[0.6032232991030583, -0.1277371997534092, 0.02610772335535516],
        0.001593822705,
        0.003467624396,
    ),
    (
        90.0,
        7,
        &[0.6098363606616237, -0.1426580934283565, 0.03945777423091286, -0.006777513830657426],
        &[0.6107382947717449, -0.1446398120625097, 0.04113602419195953, -0.007474010033054627],
        0.0002395031319,
        0.0005993544262,
    ),
    (
        90.0,
        9,
        &[0.6149631670890274, -0.1545968081280006, 0.05112737495535386, -0.01350404240773339, 0.002032151418372891],
        &[0.6155305644139111, -0.1559135769583954, 0.05240485815327302, -0.01423060845224288, 0.002245770164469653],
        3.700732102e-5,
        0.0001032884411,
    ),
    (
        120.0,
        3,
        &[0.60331370333533, -0.1247341041197618],
        &[0.6093635837629056, -0.1523408959407264],
        0.04297731218,
        0.07360904421,
    ),
    (
        120.0,
        5,
        &[0.6127306311314436, -0.1479555435951836, 0.04116019651581953],
        &[0.6154614208109231, -0.1546433481035885, 0.05120524585574357],
        0.01202331856,
        0.02509904258,
    ),
    (
        120.0,
        7,
        &[0.6181391888221038, -0.1616027470007886, 0.05690629118176789, -0.01516783995683266],
        &[0.6196905031779387, -0.1654932238062437, 0.06133280599265355, -0.01905041394561732],
        0.003520328581,
        0.008458432976,
    ),
    (
        120.0,
        9,
        &[0.6215848185989874, -0.1704833672844196, 0.06768117423854756, -0.02414707689472455, 0.005880459923944188],
        &[0.6225800219348628, -0.1730383350167078, 0.07075432295834745, -0.02666767822654357, 0.007430527713618554],
        0.001058859364,
        0.002837634668,
    ),
    (
        150.0,
        3,
        &[0.6233171305620384, -0.1738739267074776],
        &[0.6304071475209175, -0.2737062360264214],
        0.1432990885,
        0.2157262228,
    ),
    (
        150.0,
        5,
        &[0.6260408217488801, -0.1816195268936298, 0.07999243707796881],
        &[0.6291679306230424, -0.1907587821584043, 0.1342183802454832],
        0.07262752871,
        0.1322775524,
    ),
    (
        150.0,
        7,
        &[0.6279828888876263, -0.1871522835352225, 0.08828975198613505, -0.04157993145684391],
        &[0.6298963238707978, -0.1926224619076375, 0.09658435636686315, -0.0718903420099921],
        0.03803212368,
        0.07968493827,
    ),
    (
        150.0,
        9,
        &[0.629384198740239, -0.1911534278278456, 0.09431887964565774, -0.04879833016096711, 0.02280533462943635],
        &[0.6306953209441853, -0.1948942436482873, 0.0999502934078352, -0.05554532084805546, 0.04015549536795783],
        0.02036154522,
        0.04757108171,
    ),
];

#[test]
fn coefficients_and_errors_of_all_widths() {
    for (width, order, squares, minimax, least, error) in WIDTHS {
        let half = width * PI / 360.0;
        let chebyshev = symmetric_task(*order, half, Objective::Chebyshev).solve().unwrap();
        let gauss = symmetric_task(*order, half, Objective::LeastSquares).solve().unwrap();
        assert_odd(&gauss, squares, 1e-12);
        assert_odd(&chebyshev, minimax, 1e-10);
        // The coefficients are numbers of sixteen digits.
        assert!((chebyshev.objective / least - 1.0).abs() < 1e-9, "K = {order}, {width}°: {:e}", chebyshev.objective);
        assert!((worst(&chebyshev) - least).abs() < 1e-9 * least + 1e-15);
        assert!((worst(&gauss) - error).abs() < 1e-9 * error + 1e-15, "K = {order}, {width}°: {:e}", worst(&gauss));
    }
}

#[test]
fn the_widest_dwells_of_a_thousandth() {
    // K; degrees by the minimax and by least squares.
    for (order, widest) in [(3, [51.2, 44.3]), (5, [83.9, 74.4]), (7, [105.3, 95.3]), (9, [119.4, 109.9])] {
        for (objective, width) in [Objective::Chebyshev, Objective::LeastSquares].into_iter().zip(widest) {
            let error = |width: f64| {
                let profile = symmetric_task(order, width * PI / 360.0, objective).solve().unwrap();
                worst(&profile)
            };
            // One decimal is printed.
            assert!(error(width - 0.051) < 1e-3 && error(width + 0.051) > 1e-3, "K = {order}, {objective:?}");
        }
    }
}

#[test]
fn a_dwell_of_no_width_is_maximally_flat() {
    let limits: [&[f64]; 3] = [
        &[9.0 / 16.0, -1.0 / 16.0],
        &[75.0 / 128.0, -25.0 / 256.0, 3.0 / 256.0],
        &[1225.0 / 2048.0, -245.0 / 2048.0, 49.0 / 2048.0, -5.0 / 2048.0],
    ];
    for (order, limit) in [3, 5, 7].into_iter().zip(limits) {
        for objective in [Objective::Chebyshev, Objective::LeastSquares] {
            // The coefficients are even in the width; the rest is of the size of its square.
            assert_odd(&symmetric_task(order, 1e-3, objective).solve().unwrap(), limit, 2e-6);
        }
    }
}

#[test]
fn many_harmonics_leave_nothing_but_rounding() {
    let profile = symmetric_task(63, PI / 6.0, Objective::Chebyshev).solve().unwrap();
    assert!(worst(&profile) < 1e-14 && profile.objective < 1e-20, "{:e} {:e}", worst(&profile), profile.objective);
}

#[test]
fn the_cubics_of_the_source_fail_for_narrow_dwells() {
    // Cubics minus exact coefficients of K = 3 and K = 5; dwell error of the exact coefficients and of the cubics, K = 5.
    let table = [
        (0.1, [-6e-6, -3.7e-5], [4.1e-5, 3.8e-5, -9.4e-4], 1.1e-8, 8.6e-4),
        (0.2, [-1.1e-5, -1.2e-4], [5e-6, 8e-6, -2.1e-4], 7.1e-7, 2.0e-4),
        (0.3, [-4e-6, -4.8e-5], [-6e-6, 3e-6, 5.6e-5], 8.3e-6, 5.6e-5),
        (0.4, [3e-6, 5.0e-5], [-6e-6, 4e-6, 6.5e-5], 4.8e-5, 7.9e-5),
        (0.5, [5e-6, 1.0e-4], [-3e-6, 4e-6, -2.2e-5], 1.9e-4, 1.8e-4),
        (0.6, [1e-6, 7.0e-5], [-2e-6, 8e-6, -8.3e-5], 6.0e-4, 5.3e-4),
        (0.8, [-1.1e-5, -1.1e-4], [-9e-6, 1.1e-4, 4.8e-5], 3.9e-3, 4.0e-3),
        (1.0, [1.2e-5, 2.4e-4], [-5e-6, 5.7e-4, -2.3e-4], 1.81e-2, 1.87e-2),
    ];
    for (half, third, fifth, exact, cubic) in table {
        for (order, differences) in [(3, &third[..]), (5, &fifth[..])] {
            let task = symmetric_task(order, half, Objective::LeastSquares);
            let (best, by_cubics) = (task.solve().unwrap().series, cubics(&task).unwrap());
            for (i, printed) in differences.iter().enumerate() {
                let found = by_cubics.a[2 * i + 1] - best.a[2 * i + 1];
                // Two digits, or six decimals.
                assert!((found - printed).abs() < 0.051 * printed.abs() + 0.6e-6, "{half}, A{}: {found:e}", 2 * i + 1);
            }
        }
        let task = symmetric_task(5, half, Objective::LeastSquares);
        let found = task.largest_error(&cubics(&task).unwrap());
        assert!((found / cubic - 1.0).abs() < 0.05, "{half}: {found:e}");
        let best = worst(&task.solve().unwrap());
        assert!((best / exact - 1.0).abs() < 0.05, "{half}: {best:e}");
    }
    assert!(cubics(&symmetric_task(5, 0.3, Objective::Chebyshev)).is_none());
    assert!(cubics(&symmetric_task(7, 0.3, Objective::LeastSquares)).is_none());
}
