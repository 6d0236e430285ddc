/* calrig coefficient set as C header, floating point, version 3
 * To refuse what is not to be used as it is compiled: #if !CALRIG_SN1047_USABLE or
 *     CALRIG_SN1047_SIMULATED, #error. CALRIG_SN1047_USABLE is 1 where the verdict of the calibration
 *     is sound or usable, else 0; CALRIG_SN1047_SIMULATED is 1 for twins, else 0.
 * Functions: calrig_sn1047_force(pitch_deg, roll_deg, f) gives what the sensors sense;
 *     calrig_sn1047_x_v, calrig_sn1047_y_v, calrig_sn1047_z_v, each of (f, temperature_degc), the
 *     output in volts (temperature_degc is ignored where the set has no temperature coefficients).
 *     They do not check the validity: compare with CALRIG_SN1047_PITCH_MIN_DEG,
 *     CALRIG_SN1047_PITCH_MAX_DEG, CALRIG_SN1047_ROLL_MIN_DEG, CALRIG_SN1047_ROLL_MAX_DEG,
 *     CALRIG_SN1047_TEMPERATURE_MIN_DEGC, CALRIG_SN1047_TEMPERATURE_MAX_DEGC.
 *     calrig_sn1047_self_test() must return at most 1e-12.
 * calrig_sn1047_angles(outputs_v, temperature_degc, pitch_deg, roll_deg) returns 0 where all is well,
 *     -1 where there are no angles, else the sum of CALRIG_SN1047_ROLL_UNDETERMINED (near the
 *     vertical; roll is NAN), CALRIG_SN1047_OUTPUTS_DISAGREE (what the three sense is longer or
 *     shorter than gravity by more than calibration and readings explain: an output is wrong, and no
 *     one knows by this row which; do not use the angles) and CALRIG_SN1047_OUTSIDE_VALIDITY (pitch,
 *     roll, or temperature where it is a number; NAN: not known). Before #include, define
 *     CALRIG_SN1047_GRAVITY_AT_USE_MPS2 where gravity is another than that of the calibration, and
 *     CALRIG_SN1047_REDUNDANCY_LIMIT, the largest | |f|^2 - 1 |, and CALRIG_SN1047_LEAST_ACROSS, the
 *     least part of f across the longitudinal axis that tells roll, where single readings are less
 *     sharp than the dwells of the calibration, or the package is shaken.
 * sensor: {"name": "SN1047", "serial": "1047", "model": "three-axis package"}; status: engineering
 * set: sha256 8040a12d1472266897bee787ff9881a1a7aaad01db310a21ea7f023e5fe3a06d, by calrig 0.1.0 on
 *     2026-03-01T06:20:00+00:00
 * convention TP: Package axes: x forward, y right, z down. Pitch alpha (nose up) about y, then roll R
 *     (right wing down) about x; no yaw. f = (sin alpha, -cos alpha sin R, -cos alpha cos R) in local
 *     g. Source: NASA/TP-1999-209835.
 * acceleration unit: local g = 9.79826 m/s^2 (survey 2024); units are the ends of the names
 * valid: pitch [-90.0, 90.0] deg, roll [-180.0, 180.0] deg, temperature [19.0, 21.0] degC
 * axis x: output = offset_v + k_x_v_per_g*f_x + k_y_v_per_g*f_y + k_z_v_per_g*f_z. Equally, with the
 *     derived parameters: v = b + S*(cos W sin alpha - sin W cos alpha sin(R + A)); alpha = pitch_deg,
 *     R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg, A = azimuth_deg [TP (2)].
 *     Covariance in the order ["offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g"]: [[1.1e-12,
 *     1e-13, 1e-13, 1e-13], [1e-13, 2.1e-12, 1e-13, 1e-13], [1e-13, 1e-13, 2.1e-12, 1e-13], [1e-13,
 *     1e-13, 1e-13, 2.1e-12]]; its independent parts: {"replications": {"covariance": [[1e-12, 0.0,
 *     0.0, 0.0], [0.0, 2e-12, 0.0, 0.0], [0.0, 0.0, 2e-12, 0.0], [0.0, 0.0, 0.0, 2e-12]],
 *     "degrees_of_freedom": 5.0}, "table": {"covariance": [[1e-13, 1e-13, 1e-13, 1e-13], [1e-13,
 *     1e-13, 1e-13, 1e-13], [1e-13, 1e-13, 1e-13, 1e-13], [1e-13, 1e-13, 1e-13, 1e-13]],
 *     "degrees_of_freedom": null}}
 * axis y: output = offset_v + k_x_v_per_g*f_x + k_y_v_per_g*f_y + k_z_v_per_g*f_z. Equally, with the
 *     derived parameters: v = b + S*(-cos W cos alpha sin R + sin W (sin A sin alpha - cos A cos alpha
 *     cos R)); alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg,
 *     A = azimuth_deg [TP (4)]. Covariance in the order ["offset_v", "k_x_v_per_g", "k_y_v_per_g",
 *     "k_z_v_per_g"]: [[1.1e-12, 1e-13, 1e-13, 1e-13], [1e-13, 2.1e-12, 1e-13, 1e-13], [1e-13, 1e-13,
 *     2.1e-12, 1e-13], [1e-13, 1e-13, 1e-13, 2.1e-12]]; its independent parts: {"replications":
 *     {"covariance": [[1e-12, 0.0, 0.0, 0.0], [0.0, 2e-12, 0.0, 0.0], [0.0, 0.0, 2e-12, 0.0], [0.0,
 *     0.0, 0.0, 2e-12]], "degrees_of_freedom": 5.0}, "table": {"covariance": [[1e-13, 1e-13, 1e-13,
 *     1e-13], [1e-13, 1e-13, 1e-13, 1e-13], [1e-13, 1e-13, 1e-13, 1e-13], [1e-13, 1e-13, 1e-13,
 *     1e-13]], "degrees_of_freedom": null}}
 * axis z: output = offset_v + k_x_v_per_g*f_x + k_y_v_per_g*f_y + k_z_v_per_g*f_z. Equally, with the
 *     derived parameters: v = b + S*(-cos W cos alpha cos R + sin W (cos A sin alpha - sin A cos alpha
 *     sin R)); alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg,
 *     A = azimuth_deg [TP (5)]. Covariance in the order ["offset_v", "k_x_v_per_g", "k_y_v_per_g",
 *     "k_z_v_per_g"]: [[1.1e-12, 1e-13, 1e-13, 1e-13], [1e-13, 2.1e-12, 1e-13, 1e-13], [1e-13, 1e-13,
 *     2.1e-12, 1e-13], [1e-13, 1e-13, 1e-13, 2.1e-12]]; its independent parts: {"replications":
 *     {"covariance": [[1e-12, 0.0, 0.0, 0.0], [0.0, 2e-12, 0.0, 0.0], [0.0, 0.0, 2e-12, 0.0], [0.0,
 *     0.0, 0.0, 2e-12]], "degrees_of_freedom": 5.0}, "table": {"covariance": [[1e-13, 1e-13, 1e-13,
 *     1e-13], [1e-13, 1e-13, 1e-13, 1e-13], [1e-13, 1e-13, 1e-13, 1e-13], [1e-13, 1e-13, 1e-13,
 *     1e-13]], "degrees_of_freedom": null}}
 * polarity: {"x": 1, "y": 1, "z": -1}
 * polarity_text: "sign along the nominal axis: +1 where the output rises as that axis is turned
 *     upwards (gyros: as the package turns right-handed about it), -1 where it falls"
 * installation: {"fixture_to_package": null, "datum": "face A", "text": "the coefficients are in the
 *     axes of the calibration fixture; the rows of fixture_to_package are the package's body axes x,
 *     y, z in fixture axes: f_package = fixture_to_package f_fixture, k_package = fixture_to_package
 *     k_fixture; null: the mount was not declared as signed axes, apply the set only to the package
 *     mounted as it was calibrated"}
 * chain_serials: {"x": null}
 * temperature_conversion: null
 * wind_off_rezero: {"terms": ["offset_v"], "text": "offset_v may be set anew wind-off at a known
 *     attitude: offset_v = output - k.f; no other term may be adjusted without a calibration"}
 * verdict of the calibration: sound
 */
#ifndef CALRIG_SN1047_H
#define CALRIG_SN1047_H 1
#include <math.h>

#define CALRIG_SN1047_SET_SHA256 "8040a12d1472266897bee787ff9881a1a7aaad01db310a21ea7f023e5fe3a06d"
#define CALRIG_SN1047_USABLE 1
#define CALRIG_SN1047_SIMULATED 0
#define CALRIG_SN1047_GRAVITY_MPS2 9.79826
#define CALRIG_SN1047_PITCH_MIN_DEG (-90.0)
#define CALRIG_SN1047_PITCH_MAX_DEG 90.0
#define CALRIG_SN1047_ROLL_MIN_DEG (-180.0)
#define CALRIG_SN1047_ROLL_MAX_DEG 180.0
#define CALRIG_SN1047_TEMPERATURE_MIN_DEGC 19.0
#define CALRIG_SN1047_TEMPERATURE_MAX_DEGC 21.0
#define CALRIG_SN1047_X_POLARITY 1
#define CALRIG_SN1047_X_SCALE_V 2.5352890439751823
#define CALRIG_SN1047_X_OFFSET_V 0.005
#define CALRIG_SN1047_X_K_X_V_PER_G 2.499904807660428
#define CALRIG_SN1047_X_K_Y_V_PER_G 0.017870898482633662
#define CALRIG_SN1047_X_K_Z_V_PER_G 0.012513337832120552
#define CALRIG_SN1047_Y_POLARITY 1
#define CALRIG_SN1047_Y_SCALE_V 2.5003193024433363
#define CALRIG_SN1047_Y_OFFSET_V (-0.0121)
#define CALRIG_SN1047_Y_K_X_V_PER_G (-0.011573494976522679)
#define CALRIG_SN1047_Y_K_Y_V_PER_G 2.4699638470266536
#define CALRIG_SN1047_Y_K_Z_V_PER_G (-0.006681960440160146)
#define CALRIG_SN1047_Z_POLARITY (-1)
#define CALRIG_SN1047_Z_SCALE_V 2.5267330065145526
#define CALRIG_SN1047_Z_OFFSET_V 0.0007
#define CALRIG_SN1047_Z_K_X_V_PER_G 0.005212892439495184
#define CALRIG_SN1047_Z_K_Y_V_PER_G (-0.0008256410515014521)
#define CALRIG_SN1047_Z_K_Z_V_PER_G (-2.519994473023556)
#define CALRIG_SN1047_ROLL_UNDETERMINED 1
#define CALRIG_SN1047_OUTPUTS_DISAGREE 2
#define CALRIG_SN1047_OUTSIDE_VALIDITY 4
#ifndef CALRIG_SN1047_GRAVITY_AT_USE_MPS2
#define CALRIG_SN1047_GRAVITY_AT_USE_MPS2 CALRIG_SN1047_GRAVITY_MPS2
#endif
#ifndef CALRIG_SN1047_REDUNDANCY_LIMIT
#define CALRIG_SN1047_REDUNDANCY_LIMIT 5.4e-05
#endif
#ifndef CALRIG_SN1047_LEAST_ACROSS
#define CALRIG_SN1047_LEAST_ACROSS 0.00014
#endif

/* pitch_deg, roll_deg, temperature_degc, x_v, y_v, z_v */
static const double calrig_sn1047_vectors[9][6] = {
    {0.0, 0.0, 0.0, -0.007513337832120552, -0.005418039559839854, 2.520694473023556},
    {-90.0, 0.0, 0.0, -2.4949048076604283, -0.0005265050234773208, -0.00451289243949503},
    {90.0, 0.0, 0.0, 2.504904807660428, -0.02367349497652268, 0.005912892439495339},
    {0.0, -90.0, 0.0, 0.022870898482633663, 2.457863847026654, -0.0001256410515012978},
    {0.0, 90.0, 0.0, -0.012870898482633661, -2.4820638470266534, 0.0015256410515016063},
    {37.8, -133.2, 0.0, 1.5542713391973593, 1.3998870286319793, -1.3596413436245367},
    {-57.6, 133.2, 0.0, -2.1081299538299367, -0.9695492683725558, -0.9277095453050531},
    {-23.4, 43.2, 0.0, -1.0074308488395782, -1.554778864849105, 1.685060830132667},
    {77.4, -32.4, 0.0, 2.4444831186468146, 0.26654259441700356, 0.46983458921232407},
};

/* of the set's coefficients, in the order offset_v, k_x_v_per_g, k_y_v_per_g, k_z_v_per_g */
static const double calrig_sn1047_x_covariance[4][4] = {
    {1.1e-12, 1e-13, 1e-13, 1e-13},
    {1e-13, 2.1e-12, 1e-13, 1e-13},
    {1e-13, 1e-13, 2.1e-12, 1e-13},
    {1e-13, 1e-13, 1e-13, 2.1e-12},
};

/* of the set's coefficients, in the order offset_v, k_x_v_per_g, k_y_v_per_g, k_z_v_per_g */
static const double calrig_sn1047_y_covariance[4][4] = {
    {1.1e-12, 1e-13, 1e-13, 1e-13},
    {1e-13, 2.1e-12, 1e-13, 1e-13},
    {1e-13, 1e-13, 2.1e-12, 1e-13},
    {1e-13, 1e-13, 1e-13, 2.1e-12},
};

/* of the set's coefficients, in the order offset_v, k_x_v_per_g, k_y_v_per_g, k_z_v_per_g */
static const double calrig_sn1047_z_covariance[4][4] = {
    {1.1e-12, 1e-13, 1e-13, 1e-13},
    {1e-13, 2.1e-12, 1e-13, 1e-13},
    {1e-13, 1e-13, 2.1e-12, 1e-13},
    {1e-13, 1e-13, 1e-13, 2.1e-12},
};

static inline void calrig_sn1047_force(double pitch_deg, double roll_deg, double f[3])
{
    const double degree = 0.017453292519943295;
    const double pitch = pitch_deg * degree, roll = roll_deg * degree;
    f[0] = sin(pitch);
    f[1] = -cos(pitch) * sin(roll);
    f[2] = -cos(pitch) * cos(roll);
}

static inline double calrig_sn1047_x_offset_v(double temperature_degc)
{
    (void)temperature_degc;
    return CALRIG_SN1047_X_OFFSET_V;
}

static inline double calrig_sn1047_x_gain(double temperature_degc)
{
    (void)temperature_degc;
    return 1.0;
}

static inline double calrig_sn1047_x_v(const double f[3], double temperature_degc)
{
    const double sensed_v = CALRIG_SN1047_X_K_X_V_PER_G * f[0] + CALRIG_SN1047_X_K_Y_V_PER_G * f[1] + CALRIG_SN1047_X_K_Z_V_PER_G * f[2];
    return calrig_sn1047_x_offset_v(temperature_degc) + calrig_sn1047_x_gain(temperature_degc) * sensed_v;
}

static inline double calrig_sn1047_y_offset_v(double temperature_degc)
{
    (void)temperature_degc;
    return CALRIG_SN1047_Y_OFFSET_V;
}

static inline double calrig_sn1047_y_gain(double temperature_degc)
{
    (void)temperature_degc;
    return 1.0;
}

static inline double calrig_sn1047_y_v(const double f[3], double temperature_degc)
{
    const double sensed_v = CALRIG_SN1047_Y_K_X_V_PER_G * f[0] + CALRIG_SN1047_Y_K_Y_V_PER_G * f[1] + CALRIG_SN1047_Y_K_Z_V_PER_G * f[2];
    return calrig_sn1047_y_offset_v(temperature_degc) + calrig_sn1047_y_gain(temperature_degc) * sensed_v;
}

static inline double calrig_sn1047_z_offset_v(double temperature_degc)
{
    (void)temperature_degc;
    return CALRIG_SN1047_Z_OFFSET_V;
}

static inline double calrig_sn1047_z_gain(double temperature_degc)
{
    (void)temperature_degc;
    return 1.0;
}

static inline double calrig_sn1047_z_v(const double f[3], double temperature_degc)
{
    const double sensed_v = CALRIG_SN1047_Z_K_X_V_PER_G * f[0] + CALRIG_SN1047_Z_K_Y_V_PER_G * f[1] + CALRIG_SN1047_Z_K_Z_V_PER_G * f[2];
    return calrig_sn1047_z_offset_v(temperature_degc) + calrig_sn1047_z_gain(temperature_degc) * sensed_v;
}

/* outputs_v in the order x, y, z; returns -1 where the force is zero or not finite, else the sum of the codes above. */
static inline int calrig_sn1047_angles(const double outputs_v[3], double temperature_degc, double *pitch_deg, double *roll_deg)
{
    const double degree = 0.017453292519943295;
    const double m[3][3] = {
        {CALRIG_SN1047_X_K_X_V_PER_G, CALRIG_SN1047_X_K_Y_V_PER_G, CALRIG_SN1047_X_K_Z_V_PER_G},
        {CALRIG_SN1047_Y_K_X_V_PER_G, CALRIG_SN1047_Y_K_Y_V_PER_G, CALRIG_SN1047_Y_K_Z_V_PER_G},
        {CALRIG_SN1047_Z_K_X_V_PER_G, CALRIG_SN1047_Z_K_Y_V_PER_G, CALRIG_SN1047_Z_K_Z_V_PER_G}
    };
    const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                             + m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2])
                             + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    const double gravity = CALRIG_SN1047_GRAVITY_AT_USE_MPS2 / CALRIG_SN1047_GRAVITY_MPS2;
    double f[3] = {0.0, 0.0, 0.0}, square, across;
    int step, i, told = 0;
    for (step = 0; step < 1; step++) { /* by Cramer's rule */
        const double s[3] = {
            (outputs_v[0] - calrig_sn1047_x_v(f, temperature_degc)) / calrig_sn1047_x_gain(temperature_degc),
            (outputs_v[1] - calrig_sn1047_y_v(f, temperature_degc)) / calrig_sn1047_y_gain(temperature_degc),
            (outputs_v[2] - calrig_sn1047_z_v(f, temperature_degc)) / calrig_sn1047_z_gain(temperature_degc)
        };
        for (i = 0; i < 3; i++) {
            const int a = (i + 1) % 3, b = (i + 2) % 3;
            f[i] += (s[0] * (m[1][a] * m[2][b] - m[1][b] * m[2][a]) + s[1] * (m[2][a] * m[0][b] - m[2][b] * m[0][a])
                   + s[2] * (m[0][a] * m[1][b] - m[0][b] * m[1][a])) / determinant;
        }
    }
    square = f[0] * f[0] + f[1] * f[1] + f[2] * f[2];
    if (!(square > 0.0) || !isfinite(square)) {
        return -1;
    }
    across = sqrt(f[1] * f[1] + f[2] * f[2]);
    *pitch_deg = atan2(f[0], across) / degree;
    *roll_deg = atan2(-f[1], -f[2]) / degree;
    if (!(fabs(square / (gravity * gravity) - 1.0) <= CALRIG_SN1047_REDUNDANCY_LIMIT)) {
        told |= CALRIG_SN1047_OUTPUTS_DISAGREE;
    }
    if (*pitch_deg < CALRIG_SN1047_PITCH_MIN_DEG - 1e-06
        || *pitch_deg > CALRIG_SN1047_PITCH_MAX_DEG + 1e-06
        || temperature_degc < CALRIG_SN1047_TEMPERATURE_MIN_DEGC
        || temperature_degc > CALRIG_SN1047_TEMPERATURE_MAX_DEGC) {
        told |= CALRIG_SN1047_OUTSIDE_VALIDITY;
    }
    if (!(across >= CALRIG_SN1047_LEAST_ACROSS * sqrt(square))) {
        *roll_deg = NAN;
        told |= CALRIG_SN1047_ROLL_UNDETERMINED;
    }
    return told;
}

static inline double calrig_sn1047_self_test(void)
{
    const int rows = (int)(sizeof calrig_sn1047_vectors / sizeof calrig_sn1047_vectors[0]);
    double largest = 0.0;
    int row;
    for (row = 0; row < rows; row++) {
        const double *vector = calrig_sn1047_vectors[row];
        double f[3], error;
        calrig_sn1047_force(vector[0], vector[1], f);
        error = fabs(calrig_sn1047_x_v(f, vector[2]) - vector[3]) / CALRIG_SN1047_X_SCALE_V;
        largest = error > largest || error != error ? error : largest; /* once not a number, always */
        error = fabs(calrig_sn1047_y_v(f, vector[2]) - vector[4]) / CALRIG_SN1047_Y_SCALE_V;
        largest = error > largest || error != error ? error : largest; /* once not a number, always */
        error = fabs(calrig_sn1047_z_v(f, vector[2]) - vector[5]) / CALRIG_SN1047_Z_SCALE_V;
        largest = error > largest || error != error ? error : largest; /* once not a number, always */
    }
    return largest;
}

#endif /* CALRIG_SN1047_H */
/* The whole set as JSON: join the lines after the bar.
 * document_json| {"format":"calrig coefficient set","version":4,"sensor":{"name":"SN1047","serial":"1047","model":"th
 * document_json| ree-axis package"},"status":"engineering","approved_by":null,"simulated":false,"acceleration_unit":{
 * document_json| "name":"local g","value_mps2":9.79826,"source":"survey 2024"},"validity":{"pitch_deg":[-90.0,90.0],"
 * document_json| roll_deg":[-180.0,180.0],"temperature_degc":[19.0,21.0]},"model":"pitch-roll","convention":{"name":"
 * document_json| TP","text":"Package axes: x forward, y right, z down. Pitch alpha (nose up) about y, then roll R (ri
 * document_json| ght wing down) about x; no yaw. f = (sin alpha, -cos alpha sin R, -cos alpha cos R) in local g. Sour
 * document_json| ce: NASA/TP-1999-209835."},"inputs":["pitch_deg","roll_deg"],"use":{"polarity":{"x":1,"y":1,"z":-1},
 * document_json| "polarity_text":"sign along the nominal axis: +1 where the output rises as that axis is turned upwar
 * document_json| ds (gyros: as the package turns right-handed about it), -1 where it falls","installation":{"fixture_
 * document_json| to_package":null,"datum":"face A","text":"the coefficients are in the axes of the calibration fixtur
 * document_json| e; the rows of fixture_to_package are the package's body axes x, y, z in fixture axes: f_package = f
 * document_json| ixture_to_package f_fixture, k_package = fixture_to_package k_fixture; null: the mount was not decla
 * document_json| red as signed axes, apply the set only to the package mounted as it was calibrated"},"chain_serials"
 * document_json| :{"x":null},"temperature_conversion":null,"wind_off_rezero":{"terms":["offset_v"],"text":"offset_v m
 * document_json| ay be set anew wind-off at a known attitude: offset_v = output - k.f; no other term may be adjusted 
 * document_json| without a calibration"}},"method_version":4,"axes":{"x":{"nominal_axis":"x","equation":{"name":"pitc
 * document_json| h-roll","source":"TP (2)","primary":"output = offset_v + k_x_v_per_g\u002af_x + k_y_v_per_g\u002af_y
 * document_json|  + k_z_v_per_g\u002af_z","derived":"v = b + S\u002a(cos W sin alpha - sin W cos alpha sin(R + A)); a
 * document_json| lpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg, A = azimuth_d
 * document_json| eg"},"parameters":{"offset_v":{"value":0.005,"unit":"V","standard_uncertainty":1e-06,"tp_standard_un
 * document_json| certainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[0.004998,0.005002]},"sensitivity_
 * document_json| v_per_g":{"value":2.5,"unit":"V/g","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"eff
 * document_json| ective_degrees_of_freedom":5.2,"interval_95":[2.499998,2.500002]},"coning_deg":{"value":0.5,"unit":"
 * document_json| deg","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2
 * document_json| ,"interval_95":[0.499998,0.500002]},"azimuth_deg":{"value":35.0,"unit":"deg","standard_uncertainty":
 * document_json| 1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[34.999998,35
 * document_json| .000002]}},"covariance_order":["offset_v","sensitivity_v_per_g","coning_deg","azimuth_deg"],"covaria
 * document_json| nce":[[1e-12,0.0,0.0,0.0],[0.0,2e-12,0.0,0.0],[0.0,0.0,1e-09,0.0],[0.0,0.0,0.0,0.001]],"primary":{"o
 * document_json| rder":["offset_v","k_x_v_per_g","k_y_v_per_g","k_z_v_per_g"],"values":{"offset_v":0.005,"k_x_v_per_g
 * document_json| ":2.499904807660428,"k_y_v_per_g":0.017870898482633662,"k_z_v_per_g":0.012513337832120552},"units":{
 * document_json| "offset_v":"V","k_x_v_per_g":"V/g","k_y_v_per_g":"V/g","k_z_v_per_g":"V/g"},"covariance":[[1.1e-12,1
 * document_json| e-13,1e-13,1e-13],[1e-13,2.1e-12,1e-13,1e-13],[1e-13,1e-13,2.1e-12,1e-13],[1e-13,1e-13,1e-13,2.1e-12
 * document_json| ]],"tp_covariance":[[9.9e-13,9.000000000000001e-14,9.000000000000001e-14,9.000000000000001e-14],[9.0
 * document_json| 00000000000001e-14,1.89e-12,9.000000000000001e-14,9.000000000000001e-14],[9.000000000000001e-14,9.00
 * document_json| 0000000000001e-14,1.89e-12,9.000000000000001e-14],[9.000000000000001e-14,9.000000000000001e-14,9.000
 * document_json| 000000000001e-14,1.89e-12]],"effective_degrees_of_freedom":{"offset_v":5.2,"k_x_v_per_g":5.3,"k_y_v_
 * document_json| per_g":6.1,"k_z_v_per_g":null},"components":{"replications":{"covariance":[[1e-12,0.0,0.0,0.0],[0.0,
 * document_json| 2e-12,0.0,0.0],[0.0,0.0,2e-12,0.0],[0.0,0.0,0.0,2e-12]],"degrees_of_freedom":5.0},"table":{"covarian
 * document_json| ce":[[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-1
 * document_json| 3,1e-13]],"degrees_of_freedom":null}}},"sensitive_axis_v_per_g":{"x":2.499904807660428,"y":0.0178708
 * document_json| 98482633662,"z":0.012513337832120552},"standard_error_v":2e-05,"degrees_of_freedom":490,"replication
 * document_json| ":{"n":2,"points":247,"lack_of_fit":{"t":0.98,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"denom
 * document_json| inator_dof":1215.0,"is_significant":false},"drift":{"offset":{"t":1.1,"f_95":1.16,"p_value":0.2,"num
 * document_json| erator_dof":243.0,"denominator_dof":1215.0,"is_significant":false},"sensitivity":{"t":1.1,"f_95":1.1
 * document_json| 6,"p_value":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,"is_significant":false},"coning":{"t"
 * document_json| :1.1,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,"is_significant":false
 * document_json| },"azimuth":{"t":1.1,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,"is_si
 * document_json| gnificant":false}},"tp":{"sigma_bias_v":4.17e-05,"sigma_prec_v":1.54e-05,"t_bias":37.3,"f_bias_95":1
 * document_json| .16,"drift":{"offset":{"t":1.1,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"denominator_dof":121
 * document_json| 5.0,"is_significant":false},"sensitivity":{"t":1.1,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"
 * document_json| denominator_dof":1215.0,"is_significant":false},"coning":{"t":1.1,"f_95":1.16,"p_value":0.2,"numerat
 * document_json| or_dof":243.0,"denominator_dof":1215.0,"is_significant":false},"azimuth":{"t":1.1,"f_95":1.16,"p_val
 * document_json| ue":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,"is_significant":false}}},"precision_v":2e-05
 * document_json| ,"lack_of_fit_v":1e-05,"per_replication":{"1":{"offset_v":0.005,"sensitivity_v_per_g":2.5,"coning_de
 * document_json| g":0.5,"azimuth_deg":35.0},"2":{"offset_v":0.005,"sensitivity_v_per_g":2.5,"coning_deg":0.5,"azimuth
 * document_json| _deg":35.0}}},"warnings":[],"findings":[],"notes":{}},"y":{"nominal_axis":"y","equation":{"name":"pi
 * document_json| tch-roll","source":"TP (4)","primary":"output = offset_v + k_x_v_per_g\u002af_x + k_y_v_per_g\u002af
 * document_json| _y + k_z_v_per_g\u002af_z","derived":"v = b + S\u002a(-cos W cos alpha sin R + sin W (sin A sin alph
 * document_json| a - cos A cos alpha cos R)); alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g,
 * document_json|  W = coning_deg, A = azimuth_deg"},"parameters":{"offset_v":{"value":-0.0121,"unit":"V","standard_un
 * document_json| certainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[-
 * document_json| 0.012102,-0.012098]},"sensitivity_v_per_g":{"value":2.47,"unit":"V/g","standard_uncertainty":1e-06,"
 * document_json| tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[2.4699980000000004,
 * document_json| 2.470002]},"coning_deg":{"value":0.31,"unit":"deg","standard_uncertainty":1e-06,"tp_standard_uncerta
 * document_json| inty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[0.309998,0.310002]},"azimuth_deg":{"va
 * document_json| lue":-120.0,"unit":"deg","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_deg
 * document_json| rees_of_freedom":5.2,"interval_95":[-120.000002,-119.999998]}},"covariance_order":["offset_v","sensi
 * document_json| tivity_v_per_g","coning_deg","azimuth_deg"],"covariance":[[1e-12,0.0,0.0,0.0],[0.0,2e-12,0.0,0.0],[0
 * document_json| .0,0.0,1e-09,0.0],[0.0,0.0,0.0,0.001]],"primary":{"order":["offset_v","k_x_v_per_g","k_y_v_per_g","k
 * document_json| _z_v_per_g"],"values":{"offset_v":-0.0121,"k_x_v_per_g":-0.011573494976522679,"k_y_v_per_g":2.469963
 * document_json| 8470266536,"k_z_v_per_g":-0.006681960440160146},"units":{"offset_v":"V","k_x_v_per_g":"V/g","k_y_v_p
 * document_json| er_g":"V/g","k_z_v_per_g":"V/g"},"covariance":[[1.1e-12,1e-13,1e-13,1e-13],[1e-13,2.1e-12,1e-13,1e-1
 * document_json| 3],[1e-13,1e-13,2.1e-12,1e-13],[1e-13,1e-13,1e-13,2.1e-12]],"tp_covariance":[[9.9e-13,9.000000000000
 * document_json| 001e-14,9.000000000000001e-14,9.000000000000001e-14],[9.000000000000001e-14,1.89e-12,9.0000000000000
 * document_json| 01e-14,9.000000000000001e-14],[9.000000000000001e-14,9.000000000000001e-14,1.89e-12,9.00000000000000
 * document_json| 1e-14],[9.000000000000001e-14,9.000000000000001e-14,9.000000000000001e-14,1.89e-12]],"effective_degr
 * document_json| ees_of_freedom":{"offset_v":5.2,"k_x_v_per_g":5.3,"k_y_v_per_g":6.1,"k_z_v_per_g":null},"components"
 * document_json| :{"replications":{"covariance":[[1e-12,0.0,0.0,0.0],[0.0,2e-12,0.0,0.0],[0.0,0.0,2e-12,0.0],[0.0,0.0
 * document_json| ,0.0,2e-12]],"degrees_of_freedom":5.0},"table":{"covariance":[[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13
 * document_json| ,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13]],"degrees_of_freedom":null}}},"sen
 * document_json| sitive_axis_v_per_g":{"x":-0.011573494976522679,"y":2.4699638470266536,"z":-0.006681960440160146},"s
 * document_json| tandard_error_v":2e-05,"degrees_of_freedom":490,"replication":null,"warnings":[],"findings":[],"note
 * document_json| s":{}},"z":{"nominal_axis":"z","equation":{"name":"pitch-roll","source":"TP (5)","primary":"output =
 * document_json|  offset_v + k_x_v_per_g\u002af_x + k_y_v_per_g\u002af_y + k_z_v_per_g\u002af_z","derived":"v = b + S
 * document_json| \u002a(-cos W cos alpha cos R + sin W (cos A sin alpha - sin A cos alpha sin R)); alpha = pitch_deg,
 * document_json|  R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg, A = azimuth_deg"},"parameters"
 * document_json| :{"offset_v":{"value":0.0007,"unit":"V","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-07
 * document_json| ,"effective_degrees_of_freedom":5.2,"interval_95":[0.0006979999999999999,0.000702]},"sensitivity_v_p
 * document_json| er_g":{"value":-2.52,"unit":"V/g","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effe
 * document_json| ctive_degrees_of_freedom":5.2,"interval_95":[-2.520002,-2.519998]},"coning_deg":{"value":0.12,"unit"
 * document_json| :"deg","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5
 * document_json| .2,"interval_95":[0.119998,0.120002]},"azimuth_deg":{"value":171.0,"unit":"deg","standard_uncertaint
 * document_json| y":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[170.99999
 * document_json| 8,171.000002]}},"covariance_order":["offset_v","sensitivity_v_per_g","coning_deg","azimuth_deg"],"co
 * document_json| variance":[[1e-12,0.0,0.0,0.0],[0.0,2e-12,0.0,0.0],[0.0,0.0,1e-09,0.0],[0.0,0.0,0.0,0.001]],"primary
 * document_json| ":{"order":["offset_v","k_x_v_per_g","k_y_v_per_g","k_z_v_per_g"],"values":{"offset_v":0.0007,"k_x_v
 * document_json| _per_g":0.005212892439495184,"k_y_v_per_g":-0.0008256410515014521,"k_z_v_per_g":-2.519994473023556},
 * document_json| "units":{"offset_v":"V","k_x_v_per_g":"V/g","k_y_v_per_g":"V/g","k_z_v_per_g":"V/g"},"covariance":[[
 * document_json| 1.1e-12,1e-13,1e-13,1e-13],[1e-13,2.1e-12,1e-13,1e-13],[1e-13,1e-13,2.1e-12,1e-13],[1e-13,1e-13,1e-1
 * document_json| 3,2.1e-12]],"tp_covariance":[[9.9e-13,9.000000000000001e-14,9.000000000000001e-14,9.000000000000001e
 * document_json| -14],[9.000000000000001e-14,1.89e-12,9.000000000000001e-14,9.000000000000001e-14],[9.000000000000001
 * document_json| e-14,9.000000000000001e-14,1.89e-12,9.000000000000001e-14],[9.000000000000001e-14,9.000000000000001e
 * document_json| -14,9.000000000000001e-14,1.89e-12]],"effective_degrees_of_freedom":{"offset_v":5.2,"k_x_v_per_g":5.
 * document_json| 3,"k_y_v_per_g":6.1,"k_z_v_per_g":null},"components":{"replications":{"covariance":[[1e-12,0.0,0.0,0
 * document_json| .0],[0.0,2e-12,0.0,0.0],[0.0,0.0,2e-12,0.0],[0.0,0.0,0.0,2e-12]],"degrees_of_freedom":5.0},"table":{
 * document_json| "covariance":[[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13],[1e-13,1
 * document_json| e-13,1e-13,1e-13]],"degrees_of_freedom":null}}},"sensitive_axis_v_per_g":{"x":0.005212892439495184,"
 * document_json| y":-0.0008256410515014521,"z":-2.519994473023556},"standard_error_v":2e-05,"degrees_of_freedom":490,
 * document_json| "replication":null,"warnings":[],"findings":[],"notes":{}}},"test_vectors":{"tolerance_relative":1e-
 * document_json| 12,"tolerance_text":"outputs: of |offset_v| + |k_x| + |k_y| + |k_z| of the axis; angles: of 180 degr
 * document_json| ees","forward":[{"pitch_deg":0.0,"roll_deg":0.0,"outputs_v":{"x":-0.007513337832120552,"y":-0.005418
 * document_json| 039559839854,"z":2.520694473023556}},{"pitch_deg":-90.0,"roll_deg":0.0,"outputs_v":{"x":-2.494904807
 * document_json| 6604283,"y":-0.0005265050234773208,"z":-0.00451289243949503}},{"pitch_deg":90.0,"roll_deg":0.0,"outp
 * document_json| uts_v":{"x":2.504904807660428,"y":-0.02367349497652268,"z":0.005912892439495339}},{"pitch_deg":0.0,"
 * document_json| roll_deg":-90.0,"outputs_v":{"x":0.022870898482633663,"y":2.457863847026654,"z":-0.00012564105150129
 * document_json| 78}},{"pitch_deg":0.0,"roll_deg":90.0,"outputs_v":{"x":-0.012870898482633661,"y":-2.4820638470266534
 * document_json| ,"z":0.0015256410515016063}},{"pitch_deg":37.8,"roll_deg":-133.2,"outputs_v":{"x":1.5542713391973593
 * document_json| ,"y":1.3998870286319793,"z":-1.3596413436245367}},{"pitch_deg":-57.6,"roll_deg":133.2,"outputs_v":{"
 * document_json| x":-2.1081299538299367,"y":-0.9695492683725558,"z":-0.9277095453050531}},{"pitch_deg":-23.4,"roll_de
 * document_json| g":43.2,"outputs_v":{"x":-1.0074308488395782,"y":-1.554778864849105,"z":1.685060830132667}},{"pitch_
 * document_json| deg":77.4,"roll_deg":-32.4,"outputs_v":{"x":2.4444831186468146,"y":0.26654259441700356,"z":0.4698345
 * document_json| 8921232407}}],"inverse":[{"pitch_deg":0.0,"roll_deg":0.0,"outputs_v":{"x":-0.007513337832120552,"y":
 * document_json| -0.005418039559839854,"z":2.520694473023556}},{"pitch_deg":0.0,"roll_deg":-90.0,"outputs_v":{"x":0.0
 * document_json| 22870898482633663,"y":2.457863847026654,"z":-0.0001256410515012978}},{"pitch_deg":0.0,"roll_deg":90.
 * document_json| 0,"outputs_v":{"x":-0.012870898482633661,"y":-2.4820638470266534,"z":0.0015256410515016063}},{"pitch
 * document_json| _deg":37.8,"roll_deg":-133.2,"outputs_v":{"x":1.5542713391973593,"y":1.3998870286319793,"z":-1.35964
 * document_json| 13436245367}},{"pitch_deg":-57.6,"roll_deg":133.2,"outputs_v":{"x":-2.1081299538299367,"y":-0.969549
 * document_json| 2683725558,"z":-0.9277095453050531}},{"pitch_deg":-23.4,"roll_deg":43.2,"outputs_v":{"x":-1.00743084
 * document_json| 88395782,"y":-1.554778864849105,"z":1.685060830132667}},{"pitch_deg":77.4,"roll_deg":-32.4,"outputs_
 * document_json| v":{"x":2.4444831186468146,"y":0.26654259441700356,"z":0.46983458921232407}}],"inverse_text":"K has 
 * document_json| one row (k_x, k_y, k_z) for each axis; f = K^-1 (outputs - offsets) (offsets and K at the temperatur
 * document_json| e); pitch = atan2(f_x, sqrt(f_y^2 + f_z^2)); roll = atan2(-f_y, -f_z)"},"verdict":"sound","warnings"
 * document_json| :[],"remarks":[],"environment":{"air":{"mean_degc":20.02,"min_degc":19.6,"max_degc":20.4}},"provenan
 * document_json| ce":{"rig":"accelerometer laboratory, dual-axis table","procedure":"three-axis, \u00b190\u00b0, six 
 * document_json| replications","operator":"J. Doe","run_id":"20260228T190000Z-three-axis","journal_sha256":"012345678
 * document_json| 9abcdef0123456789abcdef0123456789abcdef0123456789abcdef","software_version":"0.1.0","created_utc":"2
 * document_json| 026-03-01T06:20:00+00:00","standards":[{"name":"table","serial":"77","certificate":"C-2025-14","due"
 * document_json| :"2027-01-31","uncertainty":{"limit_arcsec":1.0,"kind":"limit"}},{"name":"meter","serial":"2823A","c
 * document_json| ertificate":null,"due":null,"uncertainty":null}],"mount":{"x":"+pitch","datum":"face A"},"level":nul
 * document_json| l,"chain":{"x":{"load_resistor_ohm":2500,"ratiometric":false}},"job":{"customer":"=HYPERLINK(\"http:
 * document_json| //example.invalid\")","item":"-1\r\n\u0040x"},"acceptance":null,"laboratory":{"name":"Instrument Lab
 * document_json| oratory"}},"checksum":{"algorithm":"SHA-256 of the document without this entry, as JSON with sorted 
 * document_json| keys, no spaces, UTF-8","sha256":"8040a12d1472266897bee787ff9881a1a7aaad01db310a21ea7f023e5fe3a06d"}
 * document_json| }
 */
/* sha256 of all bytes above this line: f9ca7bc5216c57b0778afbcfa82a6ad8f36761c49b9ab66d3ba4ff3fbddcf951 */
