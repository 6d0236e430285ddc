/* calrig coefficient set as C header, fixed point, version 1
 * Loses: rounds coefficients to 2^-26 V and the force to 2^-30 (bound stated in the file), and holds
 *     the uncertainty only in its comment.
 * Axis x: the output is off by at most 2.898419897409465e-08 V, 0.0024 arc seconds where the axis is
 *     most sensitive to the angle.
 * Axis y: the output is off by at most 2.8968516359165747e-08 V, 0.0024 arc seconds where the axis is
 *     most sensitive to the angle.
 * Axis z: the output is off by at most 2.8989882767808112e-08 V, 0.0024 arc seconds where the axis is
 *     most sensitive to the angle.
 * sensor: {"name": "SN1047", "serial": "SN1047", "model": "three-axis package"}; status: engineering;
 *     SIMULATED on a twin
 * set: sha256 0d312a10db24523cd687541dde7d95ba20cf7e4d01fdc69c111610ac827b5e8c, by calrig 0.1.0 on
 *     2026-11-22T10:52:22.884562+00:00
 * convention TP: Package axes: x forward, y right, z down. Pitch alpha (nose up) about y, then roll R
 *     (right wing down) about x; no yaw. f = (sin alpha, -cos alpha sin R, -cos alpha cos R) in local
 *     g. Source: NASA/TP-1999-209835.
 * acceleration unit: local g = 9.79826 m/s^2 (survey 2024, u = 2e-6 m/s\xb2); units are the ends of
 *     the names
 * valid: pitch [-60.0, 60.0] deg, roll [-180.0, 90.0] deg, temperature [20.0, 20.05] degC
 * axis x: output = offset_v + k_x_v_per_g*f_x + k_y_v_per_g*f_y + k_z_v_per_g*f_z. Equally, with the
 *     derived parameters: v = b + S*(cos W sin alpha - sin W cos alpha sin(R + A)); alpha = pitch_deg,
 *     R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg, A = azimuth_deg [TP (2)].
 *     Covariance in the order ["offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g"]:
 *     [[6.36759802010955e-12, -1.1775967429655471e-12, -1.0143721951869865e-12, 5.37356913533263e-12],
 *     [-1.1775967429655471e-12, 2.8397667555629048e-11, -1.2560399304040623e-11,
 *     -2.894865320470394e-11], [-1.0143721951869863e-12, -1.2560399304040623e-11,
 *     1.158178584838441e-11, 9.680539346089181e-12], [5.37356913533263e-12, -2.894865320470394e-11,
 *     9.680539346089181e-12, 5.862064053590134e-11]]; its independent parts: {"replications":
 *     {"covariance": [[8.549020222881969e-13, -1.1775967429655471e-12, -1.0143721951869863e-12,
 *     5.373569135332631e-12], [-1.1775967429655471e-12, 2.023913211380026e-11,
 *     -1.2502094056930626e-11, -2.8907823565363777e-11], [-1.014372195186986e-12,
 *     -1.2502094056930626e-11, 1.1580756010830404e-11, 9.680247555702522e-12], [5.373569135332631e-12,
 *     -2.8907823565363777e-11, 9.680247555702522e-12, 5.861918584008163e-11]], "degrees_of_freedom":
 *     2.0}, "table": {"covariance": [[5.5126959978213535e-12, -9.102983532898546e-29,
 *     -1.9028492182108346e-28, -4.10027752501305e-28], [-9.102983532898546e-29, 8.158535441828787e-12,
 *     -5.8305247109998e-14, -4.082963934016171e-14], [-1.9028492182108346e-28, -5.8305247109998e-14,
 *     1.029837554006009e-15, 2.9179038665873613e-16], [-4.10027752501305e-28, -4.082963934016171e-14,
 *     2.9179038665873613e-16, 1.4546958197082821e-15]], "degrees_of_freedom": null}}
 * axis y: output = offset_v + k_x_v_per_g*f_x + k_y_v_per_g*f_y + k_z_v_per_g*f_z. Equally, with the
 *     derived parameters: v = b + S*(-cos W cos alpha sin R + sin W (sin A sin alpha - cos A cos alpha
 *     cos R)); alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg,
 *     A = azimuth_deg [TP (4)]. Covariance in the order ["offset_v", "k_x_v_per_g", "k_y_v_per_g",
 *     "k_z_v_per_g"]: [[2.2091256504220025e-12, 1.217886016149939e-12, 3.2075786772774407e-12,
 *     4.076290009607167e-13], [1.2178860161499392e-12, 5.407046128096967e-12, -2.0933848302851127e-12,
 *     -9.651592397493473e-13], [3.2075786772774407e-12, -2.0933848302851127e-12,
 *     1.2066742429323994e-11, 2.049478603062052e-12], [4.076290009607167e-13, -9.651592397493473e-13,
 *     2.049478603062052e-12, 2.455006773591538e-11]]; its independent parts: {"replications":
 *     {"covariance": [[1.6460413060449275e-12, 1.217886016149939e-12, 3.2075786772774407e-12,
 *     4.0762900096071563e-13], [1.2178860161499392e-12, 5.407012847986499e-12, -2.10014960389389e-12,
 *     -9.651471449327018e-13], [3.2075786772774407e-12, -2.10014960389389e-12, 1.069160501402797e-11,
 *     2.051937089386033e-12], [4.0762900096071563e-13, -9.651471449327018e-13, 2.051937089386033e-12,
 *     4.570664514971906e-13]], "degrees_of_freedom": 2.0}, "table": {"covariance":
 *     [[5.630843443770747e-13, -2.85430328327665e-30, 1.446058512871455e-28, 1.067489286966506e-27],
 *     [-2.85430328327665e-30, 3.328011046839206e-17, 6.7647736087775044e-15, -1.2094816645506034e-17],
 *     [1.446058512871455e-28, 6.7647736087775044e-15, 1.3751374152960236e-12,
 *     -2.4584863239811003e-15], [1.067489286966506e-27, -1.2094816645506034e-17,
 *     -2.4584863239811003e-15, 2.409300128441819e-11]], "degrees_of_freedom": null}}
 * axis z: output = offset_v + k_x_v_per_g*f_x + k_y_v_per_g*f_y + k_z_v_per_g*f_z. Equally, with the
 *     derived parameters: v = b + S*(-cos W cos alpha cos R + sin W (cos A sin alpha - sin A cos alpha
 *     sin R)); alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg,
 *     A = azimuth_deg [TP (5)]. Covariance in the order ["offset_v", "k_x_v_per_g", "k_y_v_per_g",
 *     "k_z_v_per_g"]: [[6.949544585133361e-13, 3.486722833456556e-13, -5.322686744163943e-13,
 *     -9.918741479633538e-13], [3.4867228334565554e-13, 2.8421373685425244e-12, 3.590598412104575e-12,
 *     8.280452488416991e-13], [-5.322686744163944e-13, 3.590598412104575e-12, 3.335617744398584e-11,
 *     5.47056080677313e-12], [-9.918741479633538e-13, 8.280452488416991e-13, 5.47056080677313e-12,
 *     6.194654245862275e-12]]; its independent parts: {"replications": {"covariance":
 *     [[2.826986044141719e-13, 3.486722833456556e-13, -5.322686744163922e-13, -9.91874147963354e-13],
 *     [3.4867228334565554e-13, 2.8420951758389617e-12, 3.590583049298169e-12, 8.216126707861584e-13],
 *     [-5.322686744163923e-13, 3.590583049298169e-12, 8.48026777374633e-12, 5.46821863755873e-12],
 *     [-9.91874147963354e-13, 8.216126707861584e-13, 5.46821863755873e-12, 5.213820034201639e-12]],
 *     "degrees_of_freedom": 2.0}, "table": {"covariance": [[4.122558540991642e-13,
 *     1.2649354667917013e-30, -2.0770864962183584e-27, 1.0130987247424312e-28],
 *     [1.2649354667917013e-30, 4.2192703562686736e-17, 1.5362806405659964e-17, 6.432578055540744e-15],
 *     [-2.0770864962183584e-27, 1.5362806405659964e-17, 2.4875909670239508e-11,
 *     2.3421692144000686e-15], [1.0130987247424312e-28, 6.432578055540744e-15, 2.3421692144000686e-15,
 *     9.808342116606352e-13]], "degrees_of_freedom": null}}
 * polarity: {"x": 1, "y": 1, "z": 1}
 * polarity_text: "sign along the nominal axis: +1 where the output rises as that axis is turned
 *     upwards (gyros: as the package turns right-handed about it), -1 where it falls"
 * installation: {"fixture_to_package": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "datum":
 *     "", "text": "the coefficients are in the axes of the calibration fixture; the rows of
 *     fixture_to_package are the package's body axes x, y, z in fixture axes: f_package =
 *     fixture_to_package f_fixture, k_package = fixture_to_package k_fixture; null: the mount was not
 *     declared as signed axes, apply the set only to the package mounted as it was calibrated"}
 * chain_serials: {}
 * temperature_conversion: null
 * wind_off_rezero: {"terms": ["offset_v"], "text": "offset_v may be set anew wind-off at a known
 *     attitude: offset_v = output - k.f; no other term may be adjusted without a calibration"}
 * warning: 3 replications only: intervals rest on 2 degrees of freedom and are wide; four or more make
 *     them much narrower
 */
#ifndef CALRIG_SN1047_FIXED_H
#define CALRIG_SN1047_FIXED_H 1
#include <stdint.h>

#define CALRIG_SN1047_FIXED_SET_SHA256 "0d312a10db24523cd687541dde7d95ba20cf7e4d01fdc69c111610ac827b5e8c"
#define CALRIG_SN1047_FIXED_FORCE_BITS 30
#define CALRIG_SN1047_FIXED_VOLT_BITS 26
#define CALRIG_SN1047_FIXED_X_POLARITY 1
#define CALRIG_SN1047_FIXED_X_OFFSET 335572
#define CALRIG_SN1047_FIXED_X_K_X 167765713
#define CALRIG_SN1047_FIXED_X_K_Y 1198943
#define CALRIG_SN1047_FIXED_X_K_Z 839589
#define CALRIG_SN1047_FIXED_X_ERROR_V 2.898419897409465e-08
#define CALRIG_SN1047_FIXED_Y_POLARITY 1
#define CALRIG_SN1047_FIXED_Y_OFFSET (-201384)
#define CALRIG_SN1047_FIXED_Y_K_X (-818762)
#define CALRIG_SN1047_FIXED_Y_K_Y 166427822
#define CALRIG_SN1047_FIXED_Y_K_Z (-297558)
#define CALRIG_SN1047_FIXED_Y_ERROR_V 2.8968516359165747e-08
#define CALRIG_SN1047_FIXED_Z_POLARITY 1
#define CALRIG_SN1047_FIXED_Z_OFFSET 536629
#define CALRIG_SN1047_FIXED_Z_K_X (-1109232)
#define CALRIG_SN1047_FIXED_Z_K_Y 403883
#define CALRIG_SN1047_FIXED_Z_K_Z 169110251
#define CALRIG_SN1047_FIXED_Z_ERROR_V 2.8989882767808112e-08

/* f_x, f_y, f_z in 2^-30, x in 2^-26 V, y in 2^-26 V, z in 2^-26 V */
static const int32_t calrig_sn1047_fixed_vectors[9][6] = {
    {0, 759250125, -759250125, 589674, 117691263, -118756788},
    {-929887697, 379625062, -379625062, -144826747, 59454008, -58149456},
    {929887697, 379625062, -379625062, 145751992, 58035871, -60070702},
    {0, 992008094, 410903207, 1764548, 153444004, 65625460},
    {0, -410903207, -992008094, -898923, -63615646, -155855430},
    {457177033, 558646726, 794873890, 73012059, 85818845, 125464086},
    {-666952351, -688460259, -483857974, -105018807, -106268679, -75239125},
    {-288750459, 225601108, -1009281337, -45317232, 35266210, -158038187},
    {841484442, 623896595, -235750878, 132324768, 95925006, -37227859},
};


/* f in 2^-30 local g, |f| <= 2^30 each; the output in 2^-26 V, at most CALRIG_SN1047_FIXED_X_ERROR_V from the exact one */
static inline int32_t calrig_sn1047_fixed_x_counts(const int32_t f[3])
{
    const int64_t sum = (int64_t)CALRIG_SN1047_FIXED_X_K_X * f[0] + (int64_t)CALRIG_SN1047_FIXED_X_K_Y * f[1] + (int64_t)CALRIG_SN1047_FIXED_X_K_Z * f[2];
    const int64_t half = (int64_t)1 << 29, whole = (int64_t)1 << 30;
    const int64_t rounded = sum >= 0 ? (sum + half) / whole : -((half - sum) / whole);
    return (int32_t)(CALRIG_SN1047_FIXED_X_OFFSET + rounded);
}

/* f in 2^-30 local g, |f| <= 2^30 each; the output in 2^-26 V, at most CALRIG_SN1047_FIXED_Y_ERROR_V from the exact one */
static inline int32_t calrig_sn1047_fixed_y_counts(const int32_t f[3])
{
    const int64_t sum = (int64_t)CALRIG_SN1047_FIXED_Y_K_X * f[0] + (int64_t)CALRIG_SN1047_FIXED_Y_K_Y * f[1] + (int64_t)CALRIG_SN1047_FIXED_Y_K_Z * f[2];
    const int64_t half = (int64_t)1 << 29, whole = (int64_t)1 << 30;
    const int64_t rounded = sum >= 0 ? (sum + half) / whole : -((half - sum) / whole);
    return (int32_t)(CALRIG_SN1047_FIXED_Y_OFFSET + rounded);
}

/* f in 2^-30 local g, |f| <= 2^30 each; the output in 2^-26 V, at most CALRIG_SN1047_FIXED_Z_ERROR_V from the exact one */
static inline int32_t calrig_sn1047_fixed_z_counts(const int32_t f[3])
{
    const int64_t sum = (int64_t)CALRIG_SN1047_FIXED_Z_K_X * f[0] + (int64_t)CALRIG_SN1047_FIXED_Z_K_Y * f[1] + (int64_t)CALRIG_SN1047_FIXED_Z_K_Z * f[2];
    const int64_t half = (int64_t)1 << 29, whole = (int64_t)1 << 30;
    const int64_t rounded = sum >= 0 ? (sum + half) / whole : -((half - sum) / whole);
    return (int32_t)(CALRIG_SN1047_FIXED_Z_OFFSET + rounded);
}

/* The number of test vectors that are not reproduced exactly: must be 0. */
static inline int calrig_sn1047_fixed_self_test(void)
{
    const int rows = (int)(sizeof calrig_sn1047_fixed_vectors / sizeof calrig_sn1047_fixed_vectors[0]);
    int wrong = 0, row;
    for (row = 0; row < rows; row++) {
        const int32_t *vector = calrig_sn1047_fixed_vectors[row];
        wrong += calrig_sn1047_fixed_x_counts(vector) != vector[3];
        wrong += calrig_sn1047_fixed_y_counts(vector) != vector[4];
        wrong += calrig_sn1047_fixed_z_counts(vector) != vector[5];
    }
    return wrong;
}

#endif /* CALRIG_SN1047_FIXED_H */
/* The whole set as JSON: join the lines after the bar.
 * document_json| {"format":"calrig coefficient set","version":1,"sensor":{"name":"SN1047","serial":"SN1047","model":"
 * document_json| three-axis package"},"status":"engineering","approved_by":null,"simulated":true,"acceleration_unit":
 * document_json| {"name":"local g","value_mps2":9.79826,"source":"survey 2024, u = 2e-6 m/s\u00b2"},"validity":{"pitc
 * document_json| h_deg":[-60.0,60.0],"roll_deg":[-180.0,90.0],"temperature_degc":[20.0,20.05]},"model":"pitch-roll","
 * document_json| convention":{"name":"TP","text":"Package axes: x forward, y right, z down. Pitch alpha (nose up) abo
 * document_json| ut y, then roll R (right wing down) about x; no yaw. f = (sin alpha, -cos alpha sin R, -cos alpha co
 * document_json| s R) in local g. Source: NASA/TP-1999-209835."},"inputs":["pitch_deg","roll_deg"],"use":{"polarity":
 * document_json| {"x":1,"y":1,"z":1},"polarity_text":"sign along the nominal axis: +1 where the output rises as that 
 * document_json| axis is turned upwards (gyros: as the package turns right-handed about it), -1 where it falls","inst
 * document_json| allation":{"fixture_to_package":[[1.0,0.0,0.0],[0.0,1.0,0.0],[0.0,0.0,1.0]],"datum":"","text":"the c
 * document_json| oefficients are in the axes of the calibration fixture; the rows of fixture_to_package are the packa
 * document_json| ge's body axes x, y, z in fixture axes: f_package = fixture_to_package f_fixture, k_package = fixtur
 * document_json| e_to_package k_fixture; null: the mount was not declared as signed axes, apply the set only to the p
 * document_json| ackage mounted as it was calibrated"},"chain_serials":{},"temperature_conversion":null,"wind_off_rez
 * document_json| ero":{"terms":["offset_v"],"text":"offset_v may be set anew wind-off at a known attitude: offset_v =
 * document_json|  output - k.f; no other term may be adjusted without a calibration"}},"axes":{"x":{"nominal_axis":"x
 * document_json| ","equation":{"name":"pitch-roll","source":"TP (2)","primary":"output = offset_v + k_x_v_per_g\u002a
 * document_json| f_x + k_y_v_per_g\u002af_y + k_z_v_per_g\u002af_z","derived":"v = b + S\u002a(cos W sin alpha - sin 
 * document_json| W cos alpha sin(R + A)); alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W =
 * document_json|  coning_deg, A = azimuth_deg"},"parameters":{"offset_v":{"value":0.005000408025093143,"unit":"V","st
 * document_json| andard_uncertainty":2.523409998416736e-06,"tp_standard_uncertainty":2.009012400454299e-06,"effective
 * document_json| _degrees_of_freedom":8.690707355796048,"interval_95":[0.004994668556618975,0.005006147493567312]},"s
 * document_json| ensitivity_v_per_g":{"value":2.499999067615275,"unit":"V/g","standard_uncertainty":5.284791227922306
 * document_json| 5e-06,"tp_standard_uncertainty":2.8412807059765146e-06,"effective_degrees_of_freedom":2.458247437098
 * document_json| 1195,"interval_95":[2.499979944755479,2.500018190475071]},"coning_deg":{"value":0.49986883162451945,
 * document_json| "unit":"deg","standard_uncertainty":0.00013869795026068423,"tp_standard_uncertainty":9.2084627325167
 * document_json| 12e-05,"effective_degrees_of_freedom":2.000102602280305,"interval_95":[0.49927209184578664,0.5004655
 * document_json| 714032523]},"azimuth_deg":{"value":35.00254899801378,"unit":"deg","standard_uncertainty":0.015328161
 * document_json| 824996795,"tp_standard_uncertainty":0.010555224688758108,"effective_degrees_of_freedom":2.0000347359
 * document_json| 29459,"interval_95":[34.936598323773694,35.068499672253864]}},"covariance_order":["offset_v","sensit
 * document_json| ivity_v_per_g","coning_deg","azimuth_deg"],"covariance":[[6.36759802010955e-12,-1.1579097291739434e-
 * document_json| 12,5.1832926976004195e-11,1.309147130808179e-08],[-1.1579097291739434e-12,2.792901832272456e-11,-6.1
 * document_json| 47174535293057e-10,-4.27814308131869e-08],[5.18329269760042e-11,-6.147174535293058e-10,1.92371214065
 * document_json| 15236e-08,1.53855255156891e-06],[1.309147130808179e-08,-4.278143081318691e-08,1.5385525515689098e-06
 * document_json| ,0.00023495254493328908]],"primary":{"order":["offset_v","k_x_v_per_g","k_y_v_per_g","k_z_v_per_g"],
 * document_json| "values":{"offset_v":0.005000408025093143,"k_x_v_per_g":2.499903925249217,"k_y_v_per_g":0.0178656471
 * document_json| 7496631,"k_z_v_per_g":0.012510845367935428},"units":{"offset_v":"V","k_x_v_per_g":"V/g","k_y_v_per_g
 * document_json| ":"V/g","k_z_v_per_g":"V/g"},"covariance":[[6.36759802010955e-12,-1.1775967429655471e-12,-1.01437219
 * document_json| 51869865e-12,5.37356913533263e-12],[-1.1775967429655471e-12,2.8397667555629048e-11,-1.25603993040406
 * document_json| 23e-11,-2.894865320470394e-11],[-1.0143721951869863e-12,-1.2560399304040623e-11,1.158178584838441e-1
 * document_json| 1,9.680539346089181e-12],[5.37356913533263e-12,-2.894865320470394e-11,9.680539346089181e-12,5.862064
 * document_json| 053590134e-11]],"tp_covariance":[[4.036130825179146e-12,1.493668457504406e-28,-2.3868186906223693e-2
 * document_json| 8,2.9873369150088134e-28],[1.493668457504406e-28,8.07226165035829e-12,5.862993952253738e-45,-5.28091
 * document_json| 5475729081e-29],[-2.3868186906223693e-28,5.862993952253738e-45,1.6144523300716583e-11,-1.79240214900
 * document_json| 5288e-27],[2.9873369150088134e-28,-5.280915475729081e-29,-1.792402149005288e-27,1.6144523300716583e-
 * document_json| 11]],"effective_degrees_of_freedom":{"offset_v":8.690707355796048,"k_x_v_per_g":2.4479666199458747,"
 * document_json| k_y_v_per_g":2.0001010508111663,"k_z_v_per_g":2.000028199560084},"components":{"replications":{"cova
 * document_json| riance":[[8.549020222881969e-13,-1.1775967429655471e-12,-1.0143721951869863e-12,5.373569135332631e-1
 * document_json| 2],[-1.1775967429655471e-12,2.023913211380026e-11,-1.2502094056930626e-11,-2.8907823565363777e-11],[
 * document_json| -1.014372195186986e-12,-1.2502094056930626e-11,1.1580756010830404e-11,9.680247555702522e-12],[5.3735
 * document_json| 69135332631e-12,-2.8907823565363777e-11,9.680247555702522e-12,5.861918584008163e-11]],"degrees_of_fr
 * document_json| eedom":2.0},"table":{"covariance":[[5.5126959978213535e-12,-9.102983532898546e-29,-1.902849218210834
 * document_json| 6e-28,-4.10027752501305e-28],[-9.102983532898546e-29,8.158535441828787e-12,-5.8305247109998e-14,-4.0
 * document_json| 82963934016171e-14],[-1.9028492182108346e-28,-5.8305247109998e-14,1.029837554006009e-15,2.9179038665
 * document_json| 873613e-16],[-4.10027752501305e-28,-4.082963934016171e-14,2.9179038665873613e-16,1.4546958197082821e
 * document_json| -15]],"degrees_of_freedom":null}}},"sensitive_axis_v_per_g":{"x":2.499903925249217,"y":0.01786564717
 * document_json| 496631,"z":0.012510845367935428},"standard_error_v":1.2054074402725797e-05,"degrees_of_freedom":32,"
 * document_json| replication":{"n":3,"points":12,"lack_of_fit":{"t":1.7245851581823461,"f_95":2.591096179874393,"p_va
 * document_json| lue":0.16820770350690312,"numerator_dof":8.0,"denominator_dof":16.0,"is_significant":false},"drift":
 * document_json| {"offset":{"t":0.4218406975122256,"f_95":3.633723467591628,"p_value":0.6629239622969944,"numerator_d
 * document_json| of":2.0,"denominator_dof":16.0,"is_significant":false},"sensitivity":{"t":4.050100733107032,"f_95":3
 * document_json| .633723467591628,"p_value":0.037739355274786286,"numerator_dof":2.0,"denominator_dof":16.0,"is_signi
 * document_json| ficant":false},"coning":{"t":3.7892568575535996,"f_95":3.633723467591628,"p_value":0.044960222959618
 * document_json| 386,"numerator_dof":2.0,"denominator_dof":16.0,"is_significant":false},"azimuth":{"t":3.523093357607
 * document_json| 867,"f_95":3.633723467591628,"p_value":0.053971843485018524,"numerator_dof":2.0,"denominator_dof":16
 * document_json| .0,"is_significant":false}},"tp":{"sigma_bias_v":5.773295855794209e-06,"sigma_prec_v":9.789036794659
 * document_json| 732e-06,"t_bias":1.0434916071061013,"f_bias_95":2.355081494846207,"drift":{"offset":{"t":0.339775314
 * document_json| 24047663,"f_95":3.402826105350194,"p_value":0.7152995112014022,"numerator_dof":2.0,"denominator_dof"
 * document_json| :24.0,"is_significant":false},"sensitivity":{"t":3.262189393778834,"f_95":3.402826105350194,"p_value
 * document_json| ":0.055817822440228475,"numerator_dof":2.0,"denominator_dof":24.0,"is_significant":false},"coning":{
 * document_json| "t":3.0520903912452897,"f_95":3.402826105350194,"p_value":0.06591938398718868,"numerator_dof":2.0,"d
 * document_json| enominator_dof":24.0,"is_significant":false},"azimuth":{"t":2.837706650257153,"f_95":3.4028261053501
 * document_json| 94,"p_value":0.07830213171414233,"numerator_dof":2.0,"denominator_dof":24.0,"is_significant":false}}
 * document_json| },"precision_v":9.325835455194693e-06,"lack_of_fit_v":0.0,"per_replication":{"1":{"offset_v":0.00499
 * document_json| 659901296682,"sensitivity_v_per_g":2.5000010204587424,"coning_deg":0.49977140259067426,"azimuth_deg"
 * document_json| :34.97493920473358},"2":{"offset_v":0.00499946330615008,"sensitivity_v_per_g":2.50000555812749,"coni
 * document_json| ng_deg":0.4996927016556443,"azimuth_deg":35.004805031039574},"3":{"offset_v":0.004999768648283517,"s
 * document_json| ensitivity_v_per_g":2.4999906129040315,"coning_deg":0.5001425039654223,"azimuth_deg":35.027884402609
 * document_json| 94}}},"warnings":[],"notes":{"condition_number":1.0,"precision_variance_v2":8.697120693736642e-11,"l
 * document_json| ack_of_fit_variance_v2":0.0}},"y":{"nominal_axis":"y","equation":{"name":"pitch-roll","source":"TP (
 * document_json| 4)","primary":"output = offset_v + k_x_v_per_g\u002af_x + k_y_v_per_g\u002af_y + k_z_v_per_g\u002af_
 * document_json| z","derived":"v = b + S\u002a(-cos W cos alpha sin R + sin W (sin A sin alpha - cos A cos alpha cos 
 * document_json| R)); alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg, A = azi
 * document_json| muth_deg"},"parameters":{"offset_v":{"value":-0.0030008565284286156,"unit":"V","standard_uncertainty
 * document_json| ":1.4863127700527916e-06,"tp_standard_uncertainty":1.7672764319185356e-06,"effective_degrees_of_free
 * document_json| dom":2.38121188170228,"interval_95":[-0.0030063640967674618,-0.0029953489600897695]},"sensitivity_v_
 * document_json| per_g":{"value":2.480001775016985,"unit":"V/g","standard_uncertainty":3.4756111066722334e-06,"tp_sta
 * document_json| ndard_uncertainty":3.5345314779433846e-06,"effective_degrees_of_freedom":2.144775581326786,"interval
 * document_json| _95":[2.479987747549757,2.4800158024842127]},"coning_deg":{"value":0.29990829484668013,"unit":"deg",
 * document_json| "standard_uncertainty":6.115836269742404e-05,"tp_standard_uncertainty":6.101785000506971e-05,"effect
 * document_json| ive_degrees_of_freedom":2.7366107931895094,"interval_95":[0.29970262275402904,0.30011396693933123]},
 * document_json| "azimuth_deg":{"value":-109.9723875876282,"unit":"deg","standard_uncertainty":0.021138252499907095,"
 * document_json| tp_standard_uncertainty":0.015138738405448108,"effective_degrees_of_freedom":15.206967681721224,"int
 * document_json| erval_95":[-110.0173893615565,-109.92738581369991]}},"covariance_order":["offset_v","sensitivity_v_p
 * document_json| er_g","coning_deg","azimuth_deg"],"covariance":[[2.2091256504220025e-12,3.200814483901166e-12,-3.004
 * document_json| 8931854429343e-11,-1.4510990630888588e-10],[3.200814483901166e-12,1.2079872564823388e-11,2.867020284
 * document_json| 5663314e-11,1.1532746140732464e-08],[-3.0048931854429343e-11,2.8670202845663314e-11,3.74034532782966
 * document_json| 8e-09,-5.525998636855858e-07],[-1.451099063088863e-10,1.1532746140732463e-08,-5.525998636855858e-07,
 * document_json| 0.00044682571874982857]],"primary":{"order":["offset_v","k_x_v_per_g","k_y_v_per_g","k_z_v_per_g"],"
 * document_json| values":{"offset_v":-0.0030008565284286156,"k_x_v_per_g":-0.01220050455550251,"k_y_v_per_g":2.479967
 * document_json| 8005466457,"k_z_v_per_g":-0.004433962992593188},"units":{"offset_v":"V","k_x_v_per_g":"V/g","k_y_v_p
 * document_json| er_g":"V/g","k_z_v_per_g":"V/g"},"covariance":[[2.2091256504220025e-12,1.217886016149939e-12,3.20757
 * document_json| 86772774407e-12,4.076290009607167e-13],[1.2178860161499392e-12,5.407046128096967e-12,-2.093384830285
 * document_json| 1127e-12,-9.651592397493473e-13],[3.2075786772774407e-12,-2.0933848302851127e-12,1.2066742429323994e
 * document_json| -11,2.049478603062052e-12],[4.076290009607167e-13,-9.651592397493473e-13,2.049478603062052e-12,2.455
 * document_json| 006773591538e-11]],"tp_covariance":[[3.1232659868147107e-12,1.1558406035301004e-28,-1.84698414298391
 * document_json| 59e-28,2.311681207060202e-28],[1.1558406035301004e-28,6.24653197362942e-12,4.536941537607785e-45,-4.
 * document_json| 086513643634429e-29],[-1.8469841429839159e-28,4.536941537607785e-45,1.2493063947258843e-11,-1.387008
 * document_json| 724236121e-27],[2.311681207060202e-28,-4.086513643634429e-29,-1.387008724236121e-27,1.24930639472588
 * document_json| 43e-11]],"effective_degrees_of_freedom":{"offset_v":2.38121188170228,"k_x_v_per_g":2.000006994196855
 * document_json| ,"k_y_v_per_g":2.1449541961586394,"k_z_v_per_g":55.5741408324599},"components":{"replications":{"cov
 * document_json| ariance":[[1.6460413060449275e-12,1.217886016149939e-12,3.2075786772774407e-12,4.0762900096071563e-1
 * document_json| 3],[1.2178860161499392e-12,5.407012847986499e-12,-2.10014960389389e-12,-9.651471449327018e-13],[3.20
 * document_json| 75786772774407e-12,-2.10014960389389e-12,1.069160501402797e-11,2.051937089386033e-12],[4.07629000960
 * document_json| 71563e-13,-9.651471449327018e-13,2.051937089386033e-12,4.570664514971906e-13]],"degrees_of_freedom":
 * document_json| 2.0},"table":{"covariance":[[5.630843443770747e-13,-2.85430328327665e-30,1.446058512871455e-28,1.067
 * document_json| 489286966506e-27],[-2.85430328327665e-30,3.328011046839206e-17,6.7647736087775044e-15,-1.20948166455
 * document_json| 06034e-17],[1.446058512871455e-28,6.7647736087775044e-15,1.3751374152960236e-12,-2.4584863239811003e
 * document_json| -15],[1.067489286966506e-27,-1.2094816645506034e-17,-2.4584863239811003e-15,2.409300128441819e-11]],
 * document_json| "degrees_of_freedom":null}}},"sensitive_axis_v_per_g":{"x":-0.01220050455550251,"y":2.47996780054664
 * document_json| 57,"z":-0.004433962992593188},"standard_error_v":1.0603658591511215e-05,"degrees_of_freedom":32,"rep
 * document_json| lication":{"n":3,"points":12,"lack_of_fit":{"t":1.6517807030765512,"f_95":2.591096179874393,"p_value
 * document_json| ":0.18690047209033478,"numerator_dof":8.0,"denominator_dof":16.0,"is_significant":false},"drift":{"o
 * document_json| ffset":{"t":0.5570068499546484,"f_95":3.633723467591628,"p_value":0.5836397446394819,"numerator_dof"
 * document_json| :2.0,"denominator_dof":16.0,"is_significant":false},"sensitivity":{"t":1.4689253832931615,"f_95":3.6
 * document_json| 33723467591628,"p_value":0.259605770624821,"numerator_dof":2.0,"denominator_dof":16.0,"is_significan
 * document_json| t":false},"coning":{"t":0.6680270491739171,"f_95":3.633723467591628,"p_value":0.526450851868696,"num
 * document_json| erator_dof":2.0,"denominator_dof":16.0,"is_significant":false},"azimuth":{"t":0.15521657379834258,"f
 * document_json| _95":3.633723467591628,"p_value":0.8575035073386391,"numerator_dof":2.0,"denominator_dof":16.0,"is_s
 * document_json| ignificant":false}},"tp":{"sigma_bias_v":6.1200044274717685e-06,"sigma_prec_v":7.905065299274681e-06
 * document_json| ,"t_bias":1.7980998462382767,"f_bias_95":2.355081494846207,"drift":{"offset":{"t":0.457590607359292,
 * document_json| "f_95":3.402826105350194,"p_value":0.6382139569573699,"numerator_dof":2.0,"denominator_dof":24.0,"is
 * document_json| _significant":false},"sensitivity":{"t":1.2067472031049833,"f_95":3.402826105350194,"p_value":0.3166
 * document_json| 8287139654205,"numerator_dof":2.0,"denominator_dof":24.0,"is_significant":false},"coning":{"t":0.548
 * document_json| 7955905551801,"f_95":3.402826105350194,"p_value":0.5847233160483035,"numerator_dof":2.0,"denominator
 * document_json| _dof":24.0,"is_significant":false},"azimuth":{"t":0.12751305712378208,"f_95":3.402826105350194,"p_va
 * document_json| lue":0.8808743052547983,"numerator_dof":2.0,"denominator_dof":24.0,"is_significant":false}}},"precis
 * document_json| ion_v":1.010140535646945e-05,"lack_of_fit_v":0.0,"per_replication":{"1":{"offset_v":-0.0029993238167
 * document_json| 33367,"sensitivity_v_per_g":2.4800079009281486,"coning_deg":0.29997540790069394,"azimuth_deg":-109.9
 * document_json| 6149791654294},"2":{"offset_v":-0.003003160924500059,"sensitivity_v_per_g":2.4799945068837914,"conin
 * document_json| g_deg":0.29993262697546913,"azimuth_deg":-109.9750765057196},"3":{"offset_v":-0.0029994629118333615,
 * document_json| "sensitivity_v_per_g":2.4800051198630855,"coning_deg":0.29981638795112087,"azimuth_deg":-109.9806257
 * document_json| 8125891}}},"warnings":[],"notes":{"condition_number":1.0,"precision_variance_v2":1.020383901757097e-
 * document_json| 10,"lack_of_fit_variance_v2":0.0}},"z":{"nominal_axis":"z","equation":{"name":"pitch-roll","source":
 * document_json| "TP (5)","primary":"output = offset_v + k_x_v_per_g\u002af_x + k_y_v_per_g\u002af_y + k_z_v_per_g\u0
 * document_json| 02af_z","derived":"v = b + S\u002a(-cos W cos alpha cos R + sin W (cos A sin alpha - sin A cos alpha
 * document_json|  sin R)); alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg, A 
 * document_json| = azimuth_deg"},"parameters":{"offset_v":{"value":0.007996395278106293,"unit":"V","standard_uncertai
 * document_json| nty":8.336392856105907e-07,"tp_standard_uncertainty":1.5346371354442455e-06,"effective_degrees_of_fr
 * document_json| eedom":3.57134744126252,"interval_95":[0.007993966936995969,0.007998823619216618]},"sensitivity_v_pe
 * document_json| r_g":{"value":2.5200005081590526,"unit":"V/g","standard_uncertainty":2.491950943814618e-06,"tp_stand
 * document_json| ard_uncertainty":3.0692412596323377e-06,"effective_degrees_of_freedom":2.2106920949216113,"interval_
 * document_json| 95":[2.5199907082636397,2.5200103080544656]},"coning_deg":{"value":0.39994649329834503,"unit":"deg",
 * document_json| "standard_uncertainty":4.598262244910039e-05,"tp_standard_uncertainty":5.215413967251086e-05,"effect
 * document_json| ive_degrees_of_freedom":4.62352781116769,"interval_95":[0.39982533682271165,0.4000676497739784]},"az
 * document_json| imuth_deg":{"value":159.99291628631823,"unit":"deg","standard_uncertainty":0.018452327567511265,"tp_
 * document_json| standard_uncertainty":0.009700308081421503,"effective_degrees_of_freedom":4.310390739657761,"interva
 * document_json| l_95":[159.94310706399273,160.04272550864374]}},"covariance_order":["offset_v","sensitivity_v_per_g"
 * document_json| ,"coning_deg","azimuth_deg"],"covariance":[[6.949544585133361e-13,-9.954081240848008e-13,-1.14319255
 * document_json| 14515192e-11,1.2405196037512703e-09],[-9.954081240848008e-13,6.209819506378565e-12,2.453064510135756
 * document_json| e-11,-1.7826298281501602e-08],[-1.143192551451519e-11,2.4530645101357558e-11,2.114401567296511e-09,-
 * document_json| 5.200230330876467e-07],[1.2405196037512707e-09,-1.7826298281501602e-08,-5.200230330876467e-07,0.0003
 * document_json| 404883926587362]],"primary":{"order":["offset_v","k_x_v_per_g","k_y_v_per_g","k_z_v_per_g"],"values"
 * document_json| :{"offset_v":0.007996395278106293,"k_x_v_per_g":-0.016528849759959868,"k_y_v_per_g":0.00601832366860
 * document_json| 82945,"k_z_v_per_g":2.519939113952501},"units":{"offset_v":"V","k_x_v_per_g":"V/g","k_y_v_per_g":"V/
 * document_json| g","k_z_v_per_g":"V/g"},"covariance":[[6.949544585133361e-13,3.486722833456556e-13,-5.32268674416394
 * document_json| 3e-13,-9.918741479633538e-13],[3.4867228334565554e-13,2.8421373685425244e-12,3.590598412104575e-12,8
 * document_json| .280452488416991e-13],[-5.322686744163944e-13,3.590598412104575e-12,3.335617744398584e-11,5.47056080
 * document_json| 677313e-12],[-9.918741479633538e-13,8.280452488416991e-13,5.47056080677313e-12,6.194654245862275e-12
 * document_json| ]],"tp_covariance":[[2.3551111374845197e-12,8.715662034621518e-29,-1.3927257378213105e-28,1.74313240
 * document_json| 69243042e-28],[8.715662034621518e-29,4.710222274969038e-12,3.421098808248934e-45,-3.081451863605509e
 * document_json| -29],[-1.3927257378213105e-28,3.421098808248934e-45,9.420444549938079e-12,-1.0458794441545826e-27],[
 * document_json| 1.7431324069243042e-28,-3.081451863605509e-29,-1.0458794441545826e-27,9.420444549938079e-12]],"effec
 * document_json| tive_degrees_of_freedom":{"offset_v":3.57134744126252,"k_x_v_per_g":2.0000168697623137,"k_y_v_per_g"
 * document_json| :5.099596922199021,"k_z_v_per_g":2.2112932463110195},"components":{"replications":{"covariance":[[2.
 * document_json| 826986044141719e-13,3.486722833456556e-13,-5.322686744163922e-13,-9.91874147963354e-13],[3.486722833
 * document_json| 4565554e-13,2.8420951758389617e-12,3.590583049298169e-12,8.216126707861584e-13],[-5.322686744163923e
 * document_json| -13,3.590583049298169e-12,8.48026777374633e-12,5.46821863755873e-12],[-9.91874147963354e-13,8.216126
 * document_json| 707861584e-13,5.46821863755873e-12,5.213820034201639e-12]],"degrees_of_freedom":2.0},"table":{"covar
 * document_json| iance":[[4.122558540991642e-13,1.2649354667917013e-30,-2.0770864962183584e-27,1.0130987247424312e-28
 * document_json| ],[1.2649354667917013e-30,4.2192703562686736e-17,1.5362806405659964e-17,6.432578055540744e-15],[-2.0
 * document_json| 770864962183584e-27,1.5362806405659964e-17,2.4875909670239508e-11,2.3421692144000686e-15],[1.0130987
 * document_json| 247424312e-28,6.432578055540744e-15,2.3421692144000686e-15,9.808342116606352e-13]],"degrees_of_freed
 * document_json| om":null}}},"sensitive_axis_v_per_g":{"x":-0.016528849759959868,"y":0.0060183236686082945,"z":2.5199
 * document_json| 39113952501},"standard_error_v":9.207822812665473e-06,"degrees_of_freedom":32,"replication":{"n":3,"
 * document_json| points":12,"lack_of_fit":{"t":1.6693585337984023,"f_95":2.591096179874393,"p_value":0.18220177531701
 * document_json| 126,"numerator_dof":8.0,"denominator_dof":16.0,"is_significant":false},"drift":{"offset":{"t":0.1181
 * document_json| 9502378225452,"f_95":3.633723467591628,"p_value":0.889291322248936,"numerator_dof":2.0,"denominator_
 * document_json| dof":16.0,"is_significant":false},"sensitivity":{"t":0.9144281957174795,"f_95":3.633723467591628,"p_
 * document_json| value":0.4206994717416846,"numerator_dof":2.0,"denominator_dof":16.0,"is_significant":false},"coning
 * document_json| ":{"t":0.24185368501614538,"f_95":3.633723467591628,"p_value":0.7879899762327782,"numerator_dof":2.0
 * document_json| ,"denominator_dof":16.0,"is_significant":false},"azimuth":{"t":1.2392294482680484,"f_95":3.633723467
 * document_json| 591628,"p_value":0.3159612878782322,"numerator_dof":2.0,"denominator_dof":16.0,"is_significant":fals
 * document_json| e}},"tp":{"sigma_bias_v":5.38728610652188e-06,"sigma_prec_v":6.8074007378720525e-06,"t_bias":1.87887
 * document_json| 85182510548,"f_bias_95":2.355081494846207,"drift":{"offset":{"t":0.09663407597831265,"f_95":3.402826
 * document_json| 105350194,"p_value":0.9082395960087712,"numerator_dof":2.0,"denominator_dof":24.0,"is_significant":f
 * document_json| alse},"sensitivity":{"t":0.7476196620928691,"f_95":3.402826105350194,"p_value":0.48420111359507595,"
 * document_json| numerator_dof":2.0,"denominator_dof":24.0,"is_significant":false},"coning":{"t":0.1977351213746661,"
 * document_json| f_95":3.402826105350194,"p_value":0.8219105850654833,"numerator_dof":2.0,"denominator_dof":24.0,"is_
 * document_json| significant":false},"azimuth":{"t":1.0131711879776384,"f_95":3.402826105350194,"p_value":0.378074369
 * document_json| 93641114,"numerator_dof":2.0,"denominator_dof":24.0,"is_significant":false}}},"precision_v":8.845074
 * document_json| 325218254e-06,"lack_of_fit_v":0.0,"per_replication":{"1":{"offset_v":0.007996478958283338,"sensitivi
 * document_json| ty_v_per_g":2.519995747698593,"coning_deg":0.39993077588073944,"azimuth_deg":160.0098908999036},"2":
 * document_json| {"offset_v":0.007996931506433413,"sensitivity_v_per_g":2.52000373632686,"coning_deg":0.3999135126733
 * document_json| 8654,"azimuth_deg":159.97409420497456},"3":{"offset_v":0.007995236165616693,"sensitivity_v_per_g":2.
 * document_json| 52000460774931,"coning_deg":0.3999945110536669,"azimuth_deg":159.99472517070026}}},"warnings":[],"no
 * document_json| tes":{"condition_number":1.0,"precision_variance_v2":7.823533981863516e-11,"lack_of_fit_variance_v2"
 * document_json| :0.0}}},"package":{"order":["x.offset_v","x.k_x_v_per_g","x.k_y_v_per_g","x.k_z_v_per_g","y.offset_v
 * document_json| ","y.k_x_v_per_g","y.k_y_v_per_g","y.k_z_v_per_g","z.offset_v","z.k_x_v_per_g","z.k_y_v_per_g","z.k_
 * document_json| z_v_per_g"],"components":{"replications":{"covariance":[[8.549020222881969e-13,-1.1775967429655471e-
 * document_json| 12,-1.0143721951869863e-12,5.373569135332631e-12,-2.424594238481066e-13,1.7418544536073929e-12,-2.37
 * document_json| 9854696538372e-12,-6.001631125721448e-13,-3.8381167455563903e-13,4.23931753075865e-13,2.302608301901
 * document_json| 6614e-12,2.1073900832930317e-12],[-1.1775967429655471e-12,2.023913211380026e-11,-1.2502094056930626e
 * document_json| -11,-2.8907823565363777e-11,-5.084897594979483e-12,-8.280708947554778e-12,-5.422899574635594e-12,1.1
 * document_json| 038245241517682e-14,1.962227159879206e-12,6.415884894108641e-12,3.341051291713083e-12,-3.49703632231
 * document_json| 24657e-12],[-1.014372195186986e-12,-1.2502094056930626e-11,1.1580756010830404e-11,9.680247555702522e
 * document_json| -12,4.333384402914665e-12,2.324216477445901e-12,9.319940356538093e-12,1.3210852217318844e-12,-6.1486
 * document_json| 53388416748e-13,-5.7290413466752606e-12,-7.594549936470628e-12,-2.056881975352734e-12],[5.3735691353
 * document_json| 32631e-12,-2.8907823565363777e-11,9.680247555702522e-12,5.861918584008163e-11,4.735746545502203e-12,
 * document_json| 1.7742600076165857e-11,-4.907558668325484e-12,-2.8301478702605423e-12,-4.068474742195644e-12,-5.4213
 * document_json| 68244254626e-12,6.949832563540899e-12,1.3932588065165412e-11],[-2.424594238481066e-13,-5.08489759497
 * document_json| 9483e-12,4.333384402914665e-12,4.735746545502203e-12,1.6460413060449275e-12,1.217886016149939e-12,3.
 * document_json| 2075786772774407e-12,4.0762900096071563e-13,-3.084087369940463e-13,-2.1576799068801718e-12,-2.548734
 * document_json| 218657843e-12,-4.247293424255661e-13],[1.7418544536073929e-12,-8.280708947554778e-12,2.3242164774459
 * document_json| 01e-12,1.7742600076165857e-11,1.2178860161499392e-12,5.407012847986499e-12,-2.10014960389389e-12,-9.
 * document_json| 651471449327018e-13,-1.2348868495712284e-12,-1.3475837220068255e-12,2.6340586646939465e-12,4.4814966
 * document_json| 08799194e-12],[-2.379854696538372e-12,-5.422899574635594e-12,9.319940356538093e-12,-4.90755866832548
 * document_json| 4e-12,3.2075786772774407e-12,-2.10014960389389e-12,1.069160501402797e-11,2.051937089386033e-12,3.984
 * document_json| 49941881499e-13,-4.451651233652525e-12,-9.453842563704402e-12,-5.588795721312251e-12],[-6.0016311257
 * document_json| 21448e-13,1.1038245241517682e-14,1.3210852217318844e-12,-2.8301478702605423e-12,4.0762900096071563e-
 * document_json| 13,-9.651471449327018e-13,2.051937089386033e-12,4.570664514971906e-13,2.0663817521608998e-13,-6.0429
 * document_json| 34926721137e-13,-1.901834630792151e-12,-1.453408999271351e-12],[-3.8381167455563903e-13,1.9622271598
 * document_json| 79206e-12,-6.148653388416748e-13,-4.068474742195644e-12,-3.084087369940463e-13,-1.2348868495712284e-
 * document_json| 12,3.98449941881499e-13,2.0663817521608998e-13,2.826986044141719e-13,3.486722833456556e-13,-5.322686
 * document_json| 744163922e-13,-9.91874147963354e-13],[4.23931753075865e-13,6.415884894108641e-12,-5.7290413466752606
 * document_json| e-12,-5.421368244254626e-12,-2.1576799068801718e-12,-1.3475837220068255e-12,-4.451651233652525e-12,-
 * document_json| 6.042934926721137e-13,3.4867228334565554e-13,2.8420951758389617e-12,3.590583049298169e-12,8.21612670
 * document_json| 7861584e-13],[2.3026083019016614e-12,3.341051291713083e-12,-7.594549936470628e-12,6.949832563540899e
 * document_json| -12,-2.548734218657843e-12,2.6340586646939465e-12,-9.453842563704402e-12,-1.901834630792151e-12,-5.3
 * document_json| 22686744163923e-13,3.590583049298169e-12,8.48026777374633e-12,5.46821863755873e-12],[2.1073900832930
 * document_json| 317e-12,-3.4970363223124657e-12,-2.056881975352734e-12,1.3932588065165412e-11,-4.247293424255661e-13
 * document_json| ,4.481496608799194e-12,-5.588795721312251e-12,-1.453408999271351e-12,-9.91874147963354e-13,8.2161267
 * document_json| 07861584e-13,5.46821863755873e-12,5.213820034201639e-12]],"degrees_of_freedom":2.0},"table":{"covari
 * document_json| ance":[[5.5126959978213535e-12,-9.102983532898546e-29,-1.9028492182108346e-28,-4.10027752501305e-28,
 * document_json| -7.652989432576613e-15,-2.25598349156942e-28,4.379590371871917e-28,2.3814183822434135e-29,-1.4087628
 * document_json| 5366435e-14,2.055914768279124e-28,-3.4928237099805705e-30,-7.60660270725428e-29],[-9.102983532898546
 * document_json| e-29,8.158535441828787e-12,-5.8305247109998e-14,-4.082963934016171e-14,-1.8579834634936093e-28,-1.64
 * document_json| 77771717205997e-14,-3.349399796911225e-12,5.988430472214172e-15,-5.25481169782573e-28,-1.85534543253
 * document_json| 4749e-14,-6.755507537791089e-15,-2.82860620605626e-12],[-1.9028492182108346e-28,-5.8305247109998e-14
 * document_json| ,1.029837554006009e-15,2.9179038665873613e-16,6.389766925702553e-30,1.1775894811562844e-16,2.3719289
 * document_json| 152283606e-14,-4.279651917590047e-17,-2.665817219687689e-30,1.325928834772532e-16,1.2355066085800114
 * document_json| e-13,2.021472910142996e-14],[-4.10027752501305e-28,-4.082963934016171e-14,2.9179038665873613e-16,1.4
 * document_json| 546958197082821e-15,1.7209613849418907e-29,8.246351090095099e-17,1.6762173393616067e-14,1.7353553222
 * document_json| 428674e-13,2.109151736705221e-31,9.28513277927608e-17,3.3808143421616886e-17,1.4577050416169724e-14]
 * document_json| ,[-7.652989432576613e-15,-1.8579834634936093e-28,6.389766925702553e-30,1.7209613849418907e-29,5.6308
 * document_json| 43443770747e-13,-2.85430328327665e-30,1.446058512871455e-28,1.067489286966506e-27,1.8637425795708326
 * document_json| e-15,1.5422013496206845e-31,7.194272802149705e-28,-1.5953580330819903e-28],[-2.25598349156942e-28,-1
 * document_json| .6477771717205997e-14,1.1775894811562844e-16,8.246351090095099e-17,-2.85430328327665e-30,3.328011046
 * document_json| 839206e-17,6.7647736087775044e-15,-1.2094816645506034e-17,1.3745120774431826e-30,3.747236095479352e-
 * document_json| 17,1.3644080096884847e-17,5.712928217765941e-15],[4.379590371871917e-28,-3.349399796911225e-12,2.371
 * document_json| 9289152283606e-14,1.6762173393616067e-14,1.446058512871455e-28,6.7647736087775044e-15,1.375137415296
 * document_json| 0236e-12,-2.4584863239811003e-15,4.11811065689615e-28,7.61692298726974e-15,-4.099703418827775e-14,1.
 * document_json| 1612541392579869e-12],[2.3814183822434135e-29,5.988430472214172e-15,-4.279651917590047e-17,1.7353553
 * document_json| 222428674e-13,1.067489286966506e-27,-1.2094816645506034e-17,-2.4584863239811003e-15,2.40930012844181
 * document_json| 9e-11,-7.505243073297912e-28,-1.3618384333676341e-17,-4.958596733814109e-18,5.6392063570218646e-14],
 * document_json| [-1.40876285366435e-14,-5.25481169782573e-28,-2.665817219687689e-30,2.109151736705221e-31,1.86374257
 * document_json| 95708326e-15,1.3745120774431826e-30,4.11811065689615e-28,-7.505243073297912e-28,4.122558540991642e-1
 * document_json| 3,1.2649354667917013e-30,-2.0770864962183584e-27,1.0130987247424312e-28],[2.055914768279124e-28,-1.8
 * document_json| 55345432534749e-14,1.325928834772532e-16,9.28513277927608e-17,1.5422013496206845e-31,3.7472360954793
 * document_json| 52e-17,7.61692298726974e-15,-1.3618384333676341e-17,1.2649354667917013e-30,4.2192703562686736e-17,1.
 * document_json| 5362806405659964e-17,6.432578055540744e-15],[-3.4928237099805705e-30,-6.755507537791089e-15,1.235506
 * document_json| 6085800114e-13,3.3808143421616886e-17,7.194272802149705e-28,1.3644080096884847e-17,-4.09970341882777
 * document_json| 5e-14,-4.958596733814109e-18,-2.0770864962183584e-27,1.5362806405659964e-17,2.4875909670239508e-11,2
 * document_json| .3421692144000686e-15],[-7.60660270725428e-29,-2.82860620605626e-12,2.021472910142996e-14,1.45770504
 * document_json| 16169724e-14,-1.5953580330819903e-28,5.712928217765941e-15,1.1612541392579869e-12,5.6392063570218646
 * document_json| e-14,1.0130987247424312e-28,6.432578055540744e-15,2.3421692144000686e-15,9.808342116606352e-13]],"de
 * document_json| grees_of_freedom":null}},"text":"order: axis.parameter; components: independent parts of the covaria
 * document_json| nce of all primary parameters together, whose diagonal blocks are the axes' own"},"test_vectors":{"t
 * document_json| olerance_relative":1e-12,"tolerance_text":"outputs: of |offset_v| + |k_x| + |k_y| + |k_z| of the axi
 * document_json| s; angles: of 180 degrees","forward":[{"pitch_deg":0.0,"roll_deg":-45.0,"outputs_v":{"x":0.008786824
 * document_json| 694754657,"y":1.7537364776619848,"z":-1.769614042897479}},{"pitch_deg":-60.0,"roll_deg":-45.0,"outpu
 * document_json| ts_v":{"x":-2.1580866899263325,"y":0.8859337574508311,"z":-0.866494420022225}},{"pitch_deg":60.0,"ro
 * document_json| ll_deg":-45.0,"outputs_v":{"x":2.17187392264618,"y":0.8648018636827253,"z":-0.8951232275971481}},{"p
 * document_json| itch_deg":0.0,"roll_deg":-112.5,"outputs_v":{"x":0.026293807032303024,"y":2.286493831506665,"z":0.97
 * document_json| 78955508139477}},{"pitch_deg":0.0,"roll_deg":22.5,"outputs_v":{"x":-0.013394993127095814,"y":-0.9479
 * document_json| 469989397521,"z":-2.3224268880358236}},{"pitch_deg":25.2,"roll_deg":-144.9,"outputs_v":{"x":1.087964
 * document_json| 4533203017,"y":1.2788004389455212,"z":1.8695605688382408}},{"pitch_deg":-38.4,"roll_deg":54.9,"outpu
 * document_json| ts_v":{"x":-1.564902171749999,"y":-1.583526707412097,"z":-1.1211503216266738}},{"pitch_deg":-15.6,"r
 * document_json| oll_deg":-12.6,"outputs_v":{"x":-0.6752793778041102,"y":0.5255074749669215,"z":-2.35495250759323}},{
 * document_json| "pitch_deg":51.6,"roll_deg":-69.3,"outputs_v":{"x":1.9717926916708415,"y":1.4293939784834178,"z":-0.
 * document_json| 5547383359255912}}],"inverse":[{"pitch_deg":0.0,"roll_deg":-45.0,"outputs_v":{"x":0.0087868246947546
 * document_json| 57,"y":1.7537364776619848,"z":-1.769614042897479}},{"pitch_deg":-60.0,"roll_deg":-45.0,"outputs_v":{
 * document_json| "x":-2.1580866899263325,"y":0.8859337574508311,"z":-0.866494420022225}},{"pitch_deg":60.0,"roll_deg"
 * document_json| :-45.0,"outputs_v":{"x":2.17187392264618,"y":0.8648018636827253,"z":-0.8951232275971481}},{"pitch_de
 * document_json| g":0.0,"roll_deg":-112.5,"outputs_v":{"x":0.026293807032303024,"y":2.286493831506665,"z":0.977895550
 * document_json| 8139477}},{"pitch_deg":0.0,"roll_deg":22.5,"outputs_v":{"x":-0.013394993127095814,"y":-0.94794699893
 * document_json| 97521,"z":-2.3224268880358236}},{"pitch_deg":25.2,"roll_deg":-144.9,"outputs_v":{"x":1.0879644533203
 * document_json| 017,"y":1.2788004389455212,"z":1.8695605688382408}},{"pitch_deg":-38.4,"roll_deg":54.9,"outputs_v":{
 * document_json| "x":-1.564902171749999,"y":-1.583526707412097,"z":-1.1211503216266738}},{"pitch_deg":-15.6,"roll_deg
 * document_json| ":-12.6,"outputs_v":{"x":-0.6752793778041102,"y":0.5255074749669215,"z":-2.35495250759323}},{"pitch_
 * document_json| deg":51.6,"roll_deg":-69.3,"outputs_v":{"x":1.9717926916708415,"y":1.4293939784834178,"z":-0.5547383
 * document_json| 359255912}}],"inverse_text":"K has one row (k_x, k_y, k_z) for each axis; f = K^-1 (outputs - offset
 * document_json| s) (offsets and K at the temperature); pitch = atan2(f_x, sqrt(f_y^2 + f_z^2)); roll = atan2(-f_y, -
 * document_json| f_z)"},"warnings":["3 replications only: intervals rest on 2 degrees of freedom and are wide; four o
 * document_json| r more make them much narrower"],"environment":{"air":{"mean_degc":20.001063829787235,"min_degc":20.
 * document_json| 0,"max_degc":20.05}},"provenance":{"rig":"accelerometer laboratory, dual-axis table","procedure":"sm
 * document_json| all grid","operator":"tester","run_id":"20261122T095531Z-small-grid","journal_sha256":"e2a900c9a8340
 * document_json| 0b657714f6b47580d84aff0b96b9bb512d6ee70f6245e865cbb","software_version":"0.1.0","created_utc":"2026-
 * document_json| 11-22T10:52:22.884562+00:00","standards":[{"name":"table","serial":"AA-2216","certificate":"26-0117"
 * document_json| ,"due":"2027-06-30","uncertainty":{"uncertainty_arcsec":1.0,"kind":"limit","k":2.0}}],"mount":{"x":"
 * document_json| +x","y":"+y","z":"+z","datum":""},"level":{"instrument":"","uncertainty_arcsec":0.0},"chain":{},"job
 * document_json| ":{"number":"","customer":"","item":"","remarks":""},"acceptance":{"decision_rule":"guard-band"},"la
 * document_json| boratory":null},"checksum":{"algorithm":"SHA-256 of the document without this entry, as JSON with so
 * document_json| rted keys, no spaces, UTF-8","sha256":"0d312a10db24523cd687541dde7d95ba20cf7e4d01fdc69c111610ac827b5
 * document_json| e8c"}}
 */
/* sha256 of all bytes above this line: def9cc0bba96a2877f3c53970e3e5f548f836cce5f4947f5350aaab831abaa5e */
