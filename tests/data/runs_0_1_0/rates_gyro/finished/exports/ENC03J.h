/* calrig coefficient set as C header, floating point, version 1
 * Functions: calrig_enc03j_force(pitch_deg, roll_deg, yaw_deg, pitch_rate_dps, yaw_rate_dps,
 *     roll_rate_dps, f) gives what the sensors sense; calrig_enc03j_AXIS_v(f, temperature_degc) the
 *     output in volts (temperature_degc is ignored where the set has no temperature coefficients); of
 *     a package also calrig_enc03j_angles(outputs_v, temperature_degc, pitch_deg, roll_deg).
 *     calrig_enc03j_self_test() must return at most 1e-12. No function checks the validity: compare
 *     with the calrig_enc03j_..._MIN and _MAX macros.
 * sensor: {"name": "ENC03J", "serial": "ENC03J", "model": "three-axis package"}; status: engineering;
 *     SIMULATED on a twin
 * set: sha256 c89e2ac2564162e77a8b81520ea0f44dc28cfe68f3db5e6b478838e18d7c3bb6, by calrig 0.1.0 on
 *     2026-11-22T10:00:56.336521+00:00
 * convention CR: Axes: x forward, y right, z down; after half a turn about y, pitch T about y, then
 *     yaw P about the new z, then roll F about the new x. Sting package: G = (-sin T cos P, sin T sin
 *     P, cos T), gravity in local g. Model package: G_x the same, G_y = cos F G_y,sting + sin F
 *     G_z,sting, G_z = -sin F G_y,sting + cos F G_z,sting. Gyros: w = (sin P T' + F', cos P cos F T' +
 *     sin F P', -cos P sin F T' + cos F P') in deg/s, T', P', F' the rates of T, P, F. Source:
 *     NASA/CR-2003-212401.
 * acceleration unit: local g = 9.80665 m/s^2 (); units are the ends of the names
 * valid: pitch [0.0, 0.0] deg, roll [0.0, 0.0] deg, temperature null degC
 * axis x: output = offset_v + k_x_v_per_dps*w_x + k_y_v_per_dps*w_y + k_z_v_per_dps*w_z. Equally, with
 *     the derived parameters: v = b + S*(cos C w_x + sin C (sin A w_y - cos A w_z)); b = offset_v, S =
 *     sensitivity_v_per_dps, C = coning_deg, A = azimuth_deg, T = pitch_deg, P = yaw_deg, F = roll_deg
 *     [CR (III-C.16)]. Covariance in the order ["offset_v", "k_x_v_per_dps", "k_y_v_per_dps",
 *     "k_z_v_per_dps"]: [[1.128906249768734e-10, 5.386281421492666e-12, -4.1021393432744003e-25,
 *     6.86197496132124e-12], [5.386281421492667e-12, 2.5699235483425145e-13, -1.9572286837440605e-26,
 *     3.2740121915778333e-13], [-4.1021393432744003e-25, -1.9572286837440605e-26,
 *     1.490606256727429e-39, -2.4934557202749303e-26], [6.86197496132124e-12, 3.2740121915778333e-13,
 *     -2.4934557202749303e-26, 4.171001832919762e-13]]; its independent parts: {"replications":
 *     {"covariance": [[1.128906249768734e-10, 5.386281421492666e-12, -4.1021393432744003e-25,
 *     6.86197496132124e-12], [5.386281421492667e-12, 2.5699235483425145e-13, -1.9572286837440605e-26,
 *     3.2740121915778333e-13], [-4.1021393432744003e-25, -1.9572286837440605e-26,
 *     1.490606256727429e-39, -2.4934557202749303e-26], [6.86197496132124e-12, 3.2740121915778333e-13,
 *     -2.4934557202749303e-26, 4.171001832919762e-13]], "degrees_of_freedom": 1.0}}
 * axis y: output = offset_v + k_x_v_per_dps*w_x + k_y_v_per_dps*w_y + k_z_v_per_dps*w_z. Equally, with
 *     the derived parameters: v = b + S*(cos C w_y + sin C (sin A w_z - cos A w_x)); b = offset_v, S =
 *     sensitivity_v_per_dps, C = coning_deg, A = azimuth_deg, T = pitch_deg, P = yaw_deg, F = roll_deg
 *     [CR (III-C.17)]. Covariance in the order ["offset_v", "k_x_v_per_dps", "k_y_v_per_dps",
 *     "k_z_v_per_dps"]: [[2.910156250886149e-10, 1.6276031687678992e-13, 1.312933222824022e-12,
 *     1.0416660280130996e-12], [1.6276031687678992e-13, 1.5335629358927376e-13, 8.752882792028213e-14,
 *     6.944435934087341e-14], [1.312933222824022e-12, 8.752882792028213e-14, 8.485714910088575e-13,
 *     5.601844986906901e-13], [1.0416660280130996e-12, 6.94443593408734e-14, 5.6018449869069e-13,
 *     5.869495122245708e-13]]; its independent parts: {"replications": {"covariance":
 *     [[2.4414062482308853e-12, 1.6276031687678986e-13, 1.312933222824022e-12,
 *     1.0416660280130996e-12], [1.6276031687678986e-13, 1.0850681146994339e-14, 8.752882792028214e-14,
 *     6.944435934087341e-14], [1.312933222824022e-12, 8.752882792028214e-14, 7.06065878566578e-13,
 *     5.601844986906901e-13], [1.0416660280130996e-12, 6.94443593408734e-14, 5.6018449869069e-13,
 *     4.444438997822914e-13]], "degrees_of_freedom": 1.0}, "lack-of-fit": {"covariance":
 *     [[2.8857421884038403e-10, 3.893571740396653e-29, 1.1124665965724496e-29, 3.893571740396642e-29],
 *     [3.893571740396653e-29, 1.4250561244227942e-13, -1.582130120717278e-29, 0.0],
 *     [1.1124665965724496e-29, -1.582130120717278e-29, 1.4250561244227945e-13,
 *     -1.6242082800813519e-46], [3.893571740396642e-29, 0.0, -1.6242082800813519e-46,
 *     1.4250561244227947e-13]], "degrees_of_freedom": 4.0}}
 * axis z: output = offset_v + k_x_v_per_dps*w_x + k_y_v_per_dps*w_y + k_z_v_per_dps*w_z. Equally, with
 *     the derived parameters: v = b + S*(cos C w_z + sin C (sin A w_x - cos A w_y)); b = offset_v, S =
 *     sensitivity_v_per_dps, C = coning_deg, A = azimuth_deg, T = pitch_deg, P = yaw_deg, F = roll_deg
 *     [CR (III-C.18)]. Covariance in the order ["offset_v", "k_x_v_per_dps", "k_y_v_per_dps",
 *     "k_z_v_per_dps"]: [[1.2932373047883707e-09, -9.388015082254007e-12, 6.370438805817189e-12,
 *     -5.699866299525569e-12], [-9.388015082254007e-12, 8.510068660611838e-13,
 *     -2.3090249480884953e-13, 2.06596969024414e-13], [6.37043880581719e-12, -2.3090249480884953e-13,
 *     6.674133410535494e-13, -1.4019080040946717e-13], [-5.699866299525569e-12, 2.06596969024414e-13,
 *     -1.4019080040946714e-13, 6.361633793317715e-13]]; its independent parts: {"replications":
 *     {"covariance": [[2.5900878913888586e-10, -9.388015082254007e-12, 6.370438805817189e-12,
 *     -5.699866299525569e-12], [-9.388015082254007e-12, 3.402773607708308e-13, -2.309024948088495e-13,
 *     2.06596969024414e-13], [6.37043880581719e-12, -2.309024948088495e-13, 1.5668383576319634e-13,
 *     -1.4019080040946717e-13], [-5.699866299525569e-12, 2.06596969024414e-13,
 *     -1.4019080040946714e-13, 1.254338740414184e-13]], "degrees_of_freedom": 1.0}, "lack-of-fit":
 *     {"covariance": [[1.0342285156494848e-09, 1.3954271236795884e-28, 3.9869974577290533e-29,
 *     1.3954271236795844e-28], [1.3954271236795884e-28, 5.10729505290353e-13, -5.670236561287656e-29,
 *     0.0], [3.9869974577290533e-29, -5.670236561287656e-29, 5.107295052903531e-13,
 *     -5.821041551682308e-46], [1.3954271236795844e-28, 0.0, -5.821041551682308e-46,
 *     5.107295052903532e-13]], "degrees_of_freedom": 4.0}}
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
 * warning: 2 replications only: intervals rest on 1 degrees of freedom and are wide; four or more make
 *     them much narrower
 */
#ifndef CALRIG_ENC03J_H
#define CALRIG_ENC03J_H 1
#include <math.h>

#define CALRIG_ENC03J_SET_SHA256 "c89e2ac2564162e77a8b81520ea0f44dc28cfe68f3db5e6b478838e18d7c3bb6"
#define CALRIG_ENC03J_GRAVITY_MPS2 9.80665
#define CALRIG_ENC03J_PITCH_MIN_DEG 0.0
#define CALRIG_ENC03J_PITCH_MAX_DEG 0.0
#define CALRIG_ENC03J_ROLL_MIN_DEG 0.0
#define CALRIG_ENC03J_ROLL_MAX_DEG 0.0
#define CALRIG_ENC03J_YAW_MIN_DEG 0.0
#define CALRIG_ENC03J_YAW_MAX_DEG 0.0
#define CALRIG_ENC03J_RATE_MIN_DPS (-90.000055147)
#define CALRIG_ENC03J_RATE_MAX_DPS 90.000055147
#define CALRIG_ENC03J_X_POLARITY 1
#define CALRIG_ENC03J_X_SCALE_V 1.3034042256522558
#define CALRIG_ENC03J_X_OFFSET_V 0.05100281249999718
#define CALRIG_ENC03J_X_K_X_V_PER_DPS 1.2499972132365322
#define CALRIG_ENC03J_X_K_Y_V_PER_DPS 4.63888604643248e-06
#define CALRIG_ENC03J_X_K_Z_V_PER_DPS (-0.0023995610296798408)
#define CALRIG_ENC03J_Y_POLARITY 1
#define CALRIG_ENC03J_Y_SCALE_V 1.3146010110433202
#define CALRIG_ENC03J_Y_OFFSET_V 0.051957812500002636
#define CALRIG_ENC03J_Y_K_X_V_PER_DPS (-0.002639046994047011)
#define CALRIG_ENC03J_Y_K_Y_V_PER_DPS 1.2599970543313972
#define CALRIG_ENC03J_Y_K_Z_V_PER_DPS 7.097217873434094e-06
#define CALRIG_ENC03J_Z_POLARITY 1
#define CALRIG_ENC03J_Z_SCALE_V 1.3259101193504788
#define CALRIG_ENC03J_Z_OFFSET_V 0.053024218749997125
#define CALRIG_ENC03J_Z_K_X_V_PER_DPS 7.958328456903683e-06
#define CALRIG_ENC03J_Z_K_Y_V_PER_DPS (-0.00288092184583929)
#define CALRIG_ENC03J_Z_K_Z_V_PER_DPS 1.2699970204261855

/* pitch_deg, roll_deg, yaw_deg, pitch_rate_dps, yaw_rate_dps, roll_rate_dps, temperature_degc, x_v, y_v, z_v */
static const double calrig_enc03j_vectors[9][10] = {
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.05100281249999718, 0.051957812500002636, 0.053024218749997125},
    {0.0, 0.0, 0.0, -36.000022, 0.0, -36.000022, 0.0, -44.949091363953585, -45.21295811352077, 0.15645096858096041},
    {0.0, 0.0, 0.0, 36.000022, 0.0, 36.000022, 0.0, 45.051096988953574, 45.31687373852077, -0.05040253108096617},
    {0.0, 0.0, 0.0, 0.0, -18.0000112, -18.0000112, 0.0, -22.40576890031705, 0.0993329379489645, -22.807079622889326},
    {0.0, 0.0, 0.0, 0.0, 18.0000112, 18.0000112, 0.0, 22.507774525317046, 0.004582687051040764, 22.91312806038932},
    {0.0, 0.0, 0.0, 15.120009200000002, -26.640016400000004, 28.800017600000004, 0.0, 36.11493903884626, 19.02693119608731, -33.82304759816867},
    {0.0, 0.0, 0.0, -23.040014, 26.640016400000004, -28.800017600000004, 0.0, -36.01297015384603, -28.902198289377825, 33.95191295051613},
    {0.0, 0.0, 0.0, -9.3600056, 8.640005200000001, 7.200004400000001, 0.0, 9.030212608017246, -11.76056150199499, 11.05282782382687},
    {0.0, 0.0, 0.0, 30.9600188, -6.480004, -14.400008800000002, 0.0, -17.93327527301177, 39.09944661248235, -8.265869548108094},
};

/* in the order offset_v, k_x_v_per_dps, k_y_v_per_dps, k_z_v_per_dps */
static const double calrig_enc03j_x_covariance[4][4] = {
    {1.128906249768734e-10, 5.386281421492666e-12, -4.1021393432744003e-25, 6.86197496132124e-12},
    {5.386281421492667e-12, 2.5699235483425145e-13, -1.9572286837440605e-26, 3.2740121915778333e-13},
    {-4.1021393432744003e-25, -1.9572286837440605e-26, 1.490606256727429e-39, -2.4934557202749303e-26},
    {6.86197496132124e-12, 3.2740121915778333e-13, -2.4934557202749303e-26, 4.171001832919762e-13},
};

/* in the order offset_v, k_x_v_per_dps, k_y_v_per_dps, k_z_v_per_dps */
static const double calrig_enc03j_y_covariance[4][4] = {
    {2.910156250886149e-10, 1.6276031687678992e-13, 1.312933222824022e-12, 1.0416660280130996e-12},
    {1.6276031687678992e-13, 1.5335629358927376e-13, 8.752882792028213e-14, 6.944435934087341e-14},
    {1.312933222824022e-12, 8.752882792028213e-14, 8.485714910088575e-13, 5.601844986906901e-13},
    {1.0416660280130996e-12, 6.94443593408734e-14, 5.6018449869069e-13, 5.869495122245708e-13},
};

/* in the order offset_v, k_x_v_per_dps, k_y_v_per_dps, k_z_v_per_dps */
static const double calrig_enc03j_z_covariance[4][4] = {
    {1.2932373047883707e-09, -9.388015082254007e-12, 6.370438805817189e-12, -5.699866299525569e-12},
    {-9.388015082254007e-12, 8.510068660611838e-13, -2.3090249480884953e-13, 2.06596969024414e-13},
    {6.37043880581719e-12, -2.3090249480884953e-13, 6.674133410535494e-13, -1.4019080040946717e-13},
    {-5.699866299525569e-12, 2.06596969024414e-13, -1.4019080040946714e-13, 6.361633793317715e-13},
};

static inline void calrig_enc03j_force(double pitch_deg, double roll_deg, double yaw_deg, double pitch_rate_dps, double yaw_rate_dps, double roll_rate_dps, double f[3])
{
    const double degree = 0.017453292519943295;
    const double pitch = pitch_deg * degree, roll = roll_deg * degree, yaw = yaw_deg * degree;
    (void)pitch;
    f[0] = sin(yaw) * pitch_rate_dps + roll_rate_dps;
    f[1] = cos(yaw) * cos(roll) * pitch_rate_dps + sin(roll) * yaw_rate_dps;
    f[2] = -cos(yaw) * sin(roll) * pitch_rate_dps + cos(roll) * yaw_rate_dps;
}

static inline double calrig_enc03j_x_offset_v(double temperature_degc)
{
    (void)temperature_degc;
    return CALRIG_ENC03J_X_OFFSET_V;
}

static inline double calrig_enc03j_x_gain(double temperature_degc)
{
    (void)temperature_degc;
    return 1.0;
}

static inline double calrig_enc03j_x_v(const double f[3], double temperature_degc)
{
    const double sensed_v = CALRIG_ENC03J_X_K_X_V_PER_DPS * f[0] + CALRIG_ENC03J_X_K_Y_V_PER_DPS * f[1] + CALRIG_ENC03J_X_K_Z_V_PER_DPS * f[2];
    return calrig_enc03j_x_offset_v(temperature_degc) + calrig_enc03j_x_gain(temperature_degc) * sensed_v;
}

static inline double calrig_enc03j_y_offset_v(double temperature_degc)
{
    (void)temperature_degc;
    return CALRIG_ENC03J_Y_OFFSET_V;
}

static inline double calrig_enc03j_y_gain(double temperature_degc)
{
    (void)temperature_degc;
    return 1.0;
}

static inline double calrig_enc03j_y_v(const double f[3], double temperature_degc)
{
    const double sensed_v = CALRIG_ENC03J_Y_K_X_V_PER_DPS * f[0] + CALRIG_ENC03J_Y_K_Y_V_PER_DPS * f[1] + CALRIG_ENC03J_Y_K_Z_V_PER_DPS * f[2];
    return calrig_enc03j_y_offset_v(temperature_degc) + calrig_enc03j_y_gain(temperature_degc) * sensed_v;
}

static inline double calrig_enc03j_z_offset_v(double temperature_degc)
{
    (void)temperature_degc;
    return CALRIG_ENC03J_Z_OFFSET_V;
}

static inline double calrig_enc03j_z_gain(double temperature_degc)
{
    (void)temperature_degc;
    return 1.0;
}

static inline double calrig_enc03j_z_v(const double f[3], double temperature_degc)
{
    const double sensed_v = CALRIG_ENC03J_Z_K_X_V_PER_DPS * f[0] + CALRIG_ENC03J_Z_K_Y_V_PER_DPS * f[1] + CALRIG_ENC03J_Z_K_Z_V_PER_DPS * f[2];
    return calrig_enc03j_z_offset_v(temperature_degc) + calrig_enc03j_z_gain(temperature_degc) * sensed_v;
}

static inline double calrig_enc03j_self_test(void)
{
    const int rows = (int)(sizeof calrig_enc03j_vectors / sizeof calrig_enc03j_vectors[0]);
    double largest = 0.0;
    int row;
    for (row = 0; row < rows; row++) {
        const double *vector = calrig_enc03j_vectors[row];
        double f[3], error;
        calrig_enc03j_force(vector[0], vector[1], vector[2], vector[3], vector[4], vector[5], f);
        error = fabs(calrig_enc03j_x_v(f, vector[6]) - vector[7]) / CALRIG_ENC03J_X_SCALE_V;
        largest = error > largest || error != error ? error : largest; /* once not a number, always */
        error = fabs(calrig_enc03j_y_v(f, vector[6]) - vector[8]) / CALRIG_ENC03J_Y_SCALE_V;
        largest = error > largest || error != error ? error : largest; /* once not a number, always */
        error = fabs(calrig_enc03j_z_v(f, vector[6]) - vector[9]) / CALRIG_ENC03J_Z_SCALE_V;
        largest = error > largest || error != error ? error : largest; /* once not a number, always */
    }
    return largest;
}

#endif /* CALRIG_ENC03J_H */
/* The whole set as JSON: join the lines after the bar.
 * document_json| {"format":"calrig coefficient set","version":2,"sensor":{"name":"ENC03J","serial":"ENC03J","model":"
 * document_json| three-axis package"},"status":"engineering","approved_by":null,"simulated":true,"acceleration_unit":
 * document_json| {"name":"local g","value_mps2":9.80665,"source":""},"validity":{"pitch_deg":[0.0,0.0],"roll_deg":[0.
 * document_json| 0,0.0],"temperature_degc":null,"yaw_deg":[0.0,0.0],"rate_dps":[-90.000055147,90.000055147]},"model":
 * document_json| "gyro","convention":{"name":"CR","text":"Axes: x forward, y right, z down; after half a turn about y
 * document_json| , pitch T about y, then yaw P about the new z, then roll F about the new x. Sting package: G = (-sin
 * document_json|  T cos P, sin T sin P, cos T), gravity in local g. Model package: G_x the same, G_y = cos F G_y,stin
 * document_json| g + sin F G_z,sting, G_z = -sin F G_y,sting + cos F G_z,sting. Gyros: w = (sin P T' + F', cos P cos 
 * document_json| F T' + sin F P', -cos P sin F T' + cos F P') in deg/s, T', P', F' the rates of T, P, F. Source: NASA
 * document_json| /CR-2003-212401."},"inputs":["pitch_deg","roll_deg","yaw_deg","pitch_rate_dps","yaw_rate_dps","roll_
 * document_json| rate_dps"],"use":{"polarity":{"x":1,"y":1,"z":1},"polarity_text":"sign along the nominal axis: +1 wh
 * document_json| ere the output rises as that axis is turned upwards (gyros: as the package turns right-handed about 
 * document_json| it), -1 where it falls","installation":{"fixture_to_package":[[1.0,0.0,0.0],[0.0,1.0,0.0],[0.0,0.0,1
 * document_json| .0]],"datum":"","text":"the coefficients are in the axes of the calibration fixture; the rows of fix
 * document_json| ture_to_package are the package's body axes x, y, z in fixture axes: f_package = fixture_to_package 
 * document_json| f_fixture, k_package = fixture_to_package k_fixture; null: the mount was not declared as signed axes
 * document_json| , apply the set only to the package mounted as it was calibrated"},"chain_serials":{},"temperature_c
 * document_json| onversion":null,"wind_off_rezero":{"terms":["offset_v"],"text":"offset_v may be set anew wind-off at
 * document_json|  a known attitude: offset_v = output - k.f; no other term may be adjusted without a calibration"}},"
 * document_json| axes":{"x":{"nominal_axis":"x","equation":{"name":"gyro","source":"CR (III-C.16)","primary":"output 
 * document_json| = offset_v + k_x_v_per_dps\u002aw_x + k_y_v_per_dps\u002aw_y + k_z_v_per_dps\u002aw_z","derived":"v 
 * document_json| = b + S\u002a(cos C w_x + sin C (sin A w_y - cos A w_z)); b = offset_v, S = sensitivity_v_per_dps, C
 * document_json|  = coning_deg, A = azimuth_deg, T = pitch_deg, P = yaw_deg, F = roll_deg"},"parameters":{"offset_v":
 * document_json| {"value":0.05100281249999718,"unit":"V","standard_uncertainty":1.0624999998911689e-05,"tp_standard_u
 * document_json| ncertainty":1.8059553176956913e-05,"effective_degrees_of_freedom":0.9999999999926377,"interval_95":[
 * document_json| 0.0508678090746868,0.051137815925307556]},"sensitivity_v_per_dps":{"value":1.249999516405407,"unit":
 * document_json| "V/(deg/s)","standard_uncertainty":5.057034268581081e-07,"tp_standard_uncertainty":4.013231580234272
 * document_json| e-07,"effective_degrees_of_freedom":0.9999999999926377,"interval_95":[1.2499930908341295,1.250005941
 * document_json| 9766845]},"coning_deg":{"value":0.10998809138304082,"unit":"deg","standard_uncertainty":2.9647309110
 * document_json| 734316e-05,"tp_standard_uncertainty":1.8395305657179626e-05,"effective_degrees_of_freedom":0.9999999
 * document_json| 999926377,"interval_95":[0.10961138660359662,0.11036479616248501]},"azimuth_deg":{"value":0.11076536
 * document_json| 820732485,"unit":"deg","standard_uncertainty":2.9812013118626108e-05,"tp_standard_uncertainty":0.009
 * document_json| 58261945529503,"effective_degrees_of_freedom":0.9999999999926377,"interval_95":[0.11038657066503271,
 * document_json| 0.111144165749617]}},"covariance_order":["offset_v","sensitivity_v_per_dps","coning_deg","azimuth_de
 * document_json| g"],"covariance":[[1.128906249768734e-10,5.3730989098170364e-12,-3.150026592692866e-10,3.16752639352
 * document_json| 95765e-10],[5.373098909817037e-12,2.5573595593603393e-13,-1.4992745814419952e-11,1.5076037195628096e
 * document_json| -11],[-3.150026592692866e-10,-1.4992745814419955e-11,8.789629375074299e-10,-8.838459681411747e-10],[
 * document_json| 3.1675263935295765e-10,1.5076037195628096e-11,-8.838459681411747e-10,8.887561261851352e-10]],"primar
 * document_json| y":{"order":["offset_v","k_x_v_per_dps","k_y_v_per_dps","k_z_v_per_dps"],"values":{"offset_v":0.0510
 * document_json| 0281249999718,"k_x_v_per_dps":1.2499972132365322,"k_y_v_per_dps":4.63888604643248e-06,"k_z_v_per_dps
 * document_json| ":-0.0023995610296798408},"units":{"offset_v":"V","k_x_v_per_dps":"V/(deg/s)","k_y_v_per_dps":"V/(de
 * document_json| g/s)","k_z_v_per_dps":"V/(deg/s)"},"covariance":[[1.128906249768734e-10,5.386281421492666e-12,-4.102
 * document_json| 1393432744003e-25,6.86197496132124e-12],[5.386281421492667e-12,2.5699235483425145e-13,-1.95722868374
 * document_json| 40605e-26,3.2740121915778333e-13],[-4.1021393432744003e-25,-1.9572286837440605e-26,1.490606256727429
 * document_json| e-39,-2.4934557202749303e-26],[6.86197496132124e-12,3.2740121915778333e-13,-2.4934557202749303e-26,4
 * document_json| .171001832919762e-13]],"tp_covariance":[[3.2614746095133454e-10,0.0,0.0,0.0],[0.0,1.6106027716589673
 * document_json| e-13,0.0,0.0],[0.0,0.0,1.6106027716589673e-13,0.0],[0.0,0.0,0.0,1.6106027716589673e-13]],"effective_
 * document_json| degrees_of_freedom":{"offset_v":0.9999999999926377,"k_x_v_per_dps":0.9999999999926377,"k_y_v_per_dps
 * document_json| ":0.9999999999926377,"k_z_v_per_dps":0.9999999999926377},"components":{"replications":{"covariance":
 * document_json| [[1.128906249768734e-10,5.386281421492666e-12,-4.1021393432744003e-25,6.86197496132124e-12],[5.38628
 * document_json| 1421492667e-12,2.5699235483425145e-13,-1.9572286837440605e-26,3.2740121915778333e-13],[-4.1021393432
 * document_json| 744003e-25,-1.9572286837440605e-26,1.490606256727429e-39,-2.4934557202749303e-26],[6.86197496132124e
 * document_json| -12,3.2740121915778333e-13,-2.4934557202749303e-26,4.171001832919762e-13]],"degrees_of_freedom":1.0}
 * document_json| }},"sensitive_axis_v_per_g":{"x":null,"y":null,"z":null},"standard_error_v":7.223821270782764e-05,"d
 * document_json| egrees_of_freedom":12,"replication":{"n":2,"points":8,"lack_of_fit":{"t":0.6394767977368817,"f_95":6
 * document_json| .3882329086958665,"p_value":0.6622676098025364,"numerator_dof":4.0,"denominator_dof":4.0,"is_signifi
 * document_json| cant":false},"drift":{"offset":{"t":0.303930590175208,"f_95":7.708647422176786,"p_value":0.610774987
 * document_json| 593922,"numerator_dof":1.0,"denominator_dof":4.0,"is_significant":false},"sensitivity":{"t":1.394228
 * document_json| 2846987586,"f_95":7.708647422176786,"p_value":0.30310745899183195,"numerator_dof":1.0,"denominator_d
 * document_json| of":4.0,"is_significant":false},"coning":{"t":2.280799367693984,"f_95":7.708647422176786,"p_value":0
 * document_json| .20550087467705924,"numerator_dof":1.0,"denominator_dof":4.0,"is_significant":false},"azimuth":{"t":
 * document_json| 8.498546630401275e-06,"f_95":7.708647422176786,"p_value":0.9978135838566619,"numerator_dof":1.0,"den
 * document_json| ominator_dof":4.0,"is_significant":false}},"tp":{"sigma_bias_v":3.082365416934223e-05,"sigma_prec_v"
 * document_json| :5.44396167791876e-05,"t_bias":0.6411625148822749,"f_bias_95":3.837853354555897,"drift":{"offset":{"
 * document_json| t":0.3707653448889313,"f_95":5.317655071578713,"p_value":0.5594767765081111,"numerator_dof":1.0,"den
 * document_json| ominator_dof":8.0,"is_significant":false},"sensitivity":{"t":1.7008210013201248,"f_95":5.31765507157
 * document_json| 8713,"p_value":0.22845042546765462,"numerator_dof":1.0,"denominator_dof":8.0,"is_significant":false}
 * document_json| ,"coning":{"t":2.782350284970413,"f_95":5.317655071578713,"p_value":0.1338635585382047,"numerator_do
 * document_json| f":1.0,"denominator_dof":8.0,"is_significant":false},"azimuth":{"t":1.036738872075068e-05,"f_95":5.3
 * document_json| 17655071578713,"p_value":0.9975097845960834,"numerator_dof":1.0,"denominator_dof":8.0,"is_significan
 * document_json| t":false}}},"precision_v":7.709065280670139e-05,"lack_of_fit_v":0.0,"per_replication":{"1":{"offset_
 * document_json| v":0.05101343749999609,"sensitivity_v_per_dps":1.250000022109001,"coning_deg":0.10995844408593917,"a
 * document_json| zimuth_deg":0.1107951882463567},"2":{"offset_v":0.050992187499998266,"sensitivity_v_per_dps":1.24999
 * document_json| 90107021475,"coning_deg":0.11001773870416064,"azimuth_deg":0.11073556421581543}}},"warnings":[],"not
 * document_json| es":{"condition_number":1.0,"precision_variance_v2":5.942968750163376e-09,"lack_of_fit_variance_v2":
 * document_json| 0.0}},"y":{"nominal_axis":"y","equation":{"name":"gyro","source":"CR (III-C.17)","primary":"output =
 * document_json|  offset_v + k_x_v_per_dps\u002aw_x + k_y_v_per_dps\u002aw_y + k_z_v_per_dps\u002aw_z","derived":"v =
 * document_json|  b + S\u002a(cos C w_y + sin C (sin A w_z - cos A w_x)); b = offset_v, S = sensitivity_v_per_dps, C 
 * document_json| = coning_deg, A = azimuth_deg, T = pitch_deg, P = yaw_deg, F = roll_deg"},"parameters":{"offset_v":{
 * document_json| "value":0.051957812500002636,"unit":"V","standard_uncertainty":1.7059180082542506e-05,"tp_standard_u
 * document_json| ncertainty":3.260512345542567e-05,"effective_degrees_of_freedom":3.7232841229184586,"interval_95":[0
 * document_json| .0519090275360716,0.05200659746393367]},"sensitivity_v_per_dps":{"value":1.2599998180726872,"unit":"
 * document_json| V/(deg/s)","standard_uncertainty":9.209821366046212e-07,"tp_standard_uncertainty":7.245578550399131e
 * document_json| -07,"effective_degrees_of_freedom":1.0638749524214304,"interval_95":[1.2599896523388732,1.2600099838
 * document_json| 065013]},"coning_deg":{"value":0.12000550307392832,"unit":"deg","standard_uncertainty":1.78070946191
 * document_json| 70284e-05,"tp_standard_uncertainty":3.29477088102594e-05,"effective_degrees_of_freedom":2.5995384536
 * document_json| 78236,"interval_95":[0.11994355927244897,0.12006744687540767]},"azimuth_deg":{"value":0.154085793479
 * document_json| 9078,"unit":"deg","standard_uncertainty":0.016638389696643937,"tp_standard_uncertainty":0.0157306622
 * document_json| 72451044,"effective_degrees_of_freedom":1.0989761768873714,"interval_95":[-0.017237903240333863,0.32
 * document_json| 54094902001495]}},"covariance_order":["offset_v","sensitivity_v_per_dps","coning_deg","azimuth_deg"]
 * document_json| ,"covariance":[[2.910156250886149e-10,1.3125953118212555e-12,-7.398793733036792e-12,2.26247257003605
 * document_json| 4e-08],[1.3125953118212555e-12,8.482080959448131e-13,-3.977880360613437e-12,1.216393580832953e-08],[
 * document_json| -7.398793733036792e-12,-3.977880360613436e-12,3.170926187760833e-10,-6.856527005483164e-08],[2.26247
 * document_json| 2570036054e-08,1.216393580832953e-08,-6.856527005483162e-08,0.0002768360116973872]],"primary":{"orde
 * document_json| r":["offset_v","k_x_v_per_dps","k_y_v_per_dps","k_z_v_per_dps"],"values":{"offset_v":0.0519578125000
 * document_json| 02636,"k_x_v_per_dps":-0.002639046994047011,"k_y_v_per_dps":1.2599970543313972,"k_z_v_per_dps":7.097
 * document_json| 217873434094e-06},"units":{"offset_v":"V","k_x_v_per_dps":"V/(deg/s)","k_y_v_per_dps":"V/(deg/s)","k
 * document_json| _z_v_per_dps":"V/(deg/s)"},"covariance":[[2.910156250886149e-10,1.6276031687678992e-13,1.31293322282
 * document_json| 4022e-12,1.0416660280130996e-12],[1.6276031687678992e-13,1.5335629358927376e-13,8.752882792028213e-1
 * document_json| 4,6.944435934087341e-14],[1.312933222824022e-12,8.752882792028213e-14,8.485714910088575e-13,5.601844
 * document_json| 986906901e-13],[1.0416660280130996e-12,6.94443593408734e-14,5.6018449869069e-13,5.869495122245708e-1
 * document_json| 3]],"tp_covariance":[[1.0630940755435492e-09,0.0,0.0,0.0],[0.0,5.249840853000397e-13,0.0,0.0],[0.0,0
 * document_json| .0,5.249840853000397e-13,0.0],[0.0,0.0,0.0,5.249840853000397e-13]],"effective_degrees_of_freedom":{"
 * document_json| offset_v":3.7232841229184586,"k_x_v_per_dps":2.599077024234679,"k_y_v_per_dps":1.0638434454427903,"k
 * document_json| _z_v_per_dps":1.0990535677403943},"components":{"replications":{"covariance":[[2.4414062482308853e-1
 * document_json| 2,1.6276031687678986e-13,1.312933222824022e-12,1.0416660280130996e-12],[1.6276031687678986e-13,1.085
 * document_json| 0681146994339e-14,8.752882792028214e-14,6.944435934087341e-14],[1.312933222824022e-12,8.752882792028
 * document_json| 214e-14,7.06065878566578e-13,5.601844986906901e-13],[1.0416660280130996e-12,6.94443593408734e-14,5.6
 * document_json| 018449869069e-13,4.444438997822914e-13]],"degrees_of_freedom":1.0},"lack-of-fit":{"covariance":[[2.8
 * document_json| 857421884038403e-10,3.893571740396653e-29,1.1124665965724496e-29,3.893571740396642e-29],[3.893571740
 * document_json| 396653e-29,1.4250561244227942e-13,-1.582130120717278e-29,0.0],[1.1124665965724496e-29,-1.58213012071
 * document_json| 7278e-29,1.4250561244227945e-13,-1.6242082800813519e-46],[3.893571740396642e-29,0.0,-1.6242082800813
 * document_json| 519e-46,1.4250561244227947e-13]],"degrees_of_freedom":4.0}}},"sensitive_axis_v_per_g":{"x":null,"y":
 * document_json| null,"z":null},"standard_error_v":0.00013042049382170265,"degrees_of_freedom":12,"replication":{"n":
 * document_json| 2,"points":8,"lack_of_fit":{"t":1.249614596833516,"f_95":6.3882329086958665,"p_value":0.417122407182
 * document_json| 6447,"numerator_dof":4.0,"denominator_dof":4.0,"is_significant":false},"drift":{"offset":{"t":0.0021
 * document_json| 11798617381188,"f_95":7.708647422176786,"p_value":0.9655494224952456,"numerator_dof":1.0,"denominato
 * document_json| r_dof":4.0,"is_significant":false},"sensitivity":{"t":1.2361172159113738,"f_95":7.708647422176786,"p
 * document_json| _value":0.328538091354838,"numerator_dof":1.0,"denominator_dof":4.0,"is_significant":false},"coning"
 * document_json| :{"t":0.018993959061210382,"f_95":7.708647422176786,"p_value":0.8970430600493468,"numerator_dof":1.0
 * document_json| ,"denominator_dof":4.0,"is_significant":false},"azimuth":{"t":0.7791421986821896,"f_95":7.7086474221
 * document_json| 76786,"p_value":0.42725912596957233,"numerator_dof":1.0,"denominator_dof":4.0,"is_significant":false
 * document_json| }},"tp":{"sigma_bias_v":7.601719069757019e-05,"sigma_prec_v":8.353751028712691e-05,"t_bias":1.656115
 * document_json| 309356802,"f_bias_95":3.837853354555897,"drift":{"offset":{"t":0.0018774759199685458,"f_95":5.317655
 * document_json| 071578713,"p_value":0.9665005709635056,"numerator_dof":1.0,"denominator_dof":8.0,"is_significant":fa
 * document_json| lse},"sensitivity":{"t":1.0989590995376688,"f_95":5.317655071578713,"p_value":0.3251300889044367,"nu
 * document_json| merator_dof":1.0,"denominator_dof":8.0,"is_significant":false},"coning":{"t":0.016886411644010325,"f
 * document_json| _95":5.317655071578713,"p_value":0.8998157855479401,"numerator_dof":1.0,"denominator_dof":8.0,"is_si
 * document_json| gnificant":false},"azimuth":{"t":0.692689494261716,"f_95":5.317655071578713,"p_value":0.429394007872
 * document_json| 15476,"numerator_dof":1.0,"denominator_dof":8.0,"is_significant":false}}},"precision_v":0.0001360046
 * document_json| 529525989,"lack_of_fit_v":4.8047827741980904e-05,"per_replication":{"1":{"offset_v":0.05195625000000
 * document_json| 32,"sensitivity_v_per_dps":1.2599989780118683,"coning_deg":0.12001024213715705,"azimuth_deg":0.13960
 * document_json| 653100917852},"2":{"offset_v":0.05195937500000207,"sensitivity_v_per_dps":1.260000658133868,"coning_
 * document_json| deg":0.12000077168146753,"azimuth_deg":0.16856617934317342}}},"warnings":[],"notes":{"condition_numb
 * document_json| er":1.0,"precision_variance_v2":1.849726562475687e-08,"lack_of_fit_variance_v2":2.3085937507230697e-
 * document_json| 09}},"z":{"nominal_axis":"z","equation":{"name":"gyro","source":"CR (III-C.18)","primary":"output = 
 * document_json| offset_v + k_x_v_per_dps\u002aw_x + k_y_v_per_dps\u002aw_y + k_z_v_per_dps\u002aw_z","derived":"v = 
 * document_json| b + S\u002a(cos C w_z + sin C (sin A w_x - cos A w_y)); b = offset_v, S = sensitivity_v_per_dps, C =
 * document_json|  coning_deg, A = azimuth_deg, T = pitch_deg, P = yaw_deg, F = roll_deg"},"parameters":{"offset_v":{"
 * document_json| value":0.053024218749997125,"unit":"V","standard_uncertainty":3.5961608762517436e-05,"tp_standard_un
 * document_json| certainty":2.660960131568093e-05,"effective_degrees_of_freedom":1.8102267017949538,"interval_95":[0.
 * document_json| 05285285552083668,0.05319558197915757]},"sensitivity_v_per_dps":{"value":1.2700002880572137,"unit":"
 * document_json| V/(deg/s)","standard_uncertainty":7.979988494185703e-07,"tp_standard_uncertainty":5.913241113506255e
 * document_json| -07,"effective_degrees_of_freedom":1.8182302532293653,"interval_95":[1.269996503694058,1.27000407242
 * document_json| 03694]},"coning_deg":{"value":0.1299727533887826,"unit":"deg","standard_uncertainty":3.6874304120706
 * document_json| 64e-05,"tp_standard_uncertainty":2.6677455291402634e-05,"effective_degrees_of_freedom":1.70111861378
 * document_json| 48722,"interval_95":[0.1297841470846423,0.13016135969292292]},"azimuth_deg":{"value":0.1582748498948
 * document_json| 3764,"unit":"deg","standard_uncertainty":0.018332847101519046,"tp_standard_uncertainty":0.0117602102
 * document_json| 54927976,"effective_degrees_of_freedom":1.3890658350675928,"interval_95":[0.03474932418053624,0.2818
 * document_json| 0037560913906]}},"covariance_order":["offset_v","sensitivity_v_per_dps","coning_deg","azimuth_deg"],
 * document_json| "covariance":[[1.2932373047883707e-09,-5.7143614333802455e-12,-2.8798574550061314e-10,-1.86357454732
 * document_json| 346e-07],[-5.7143614333802455e-12,6.36802163673362e-13,6.353663298157533e-12,4.111496971534792e-09],
 * document_json| [-2.879857455006132e-10,6.353663298157534e-12,1.3597143043863628e-09,2.0720644542264317e-07],[-1.863
 * document_json| 57454732346e-07,4.111496971534793e-09,2.0720644542264317e-07,0.0003360932828476753]],"primary":{"ord
 * document_json| er":["offset_v","k_x_v_per_dps","k_y_v_per_dps","k_z_v_per_dps"],"values":{"offset_v":0.053024218749
 * document_json| 997125,"k_x_v_per_dps":7.958328456903683e-06,"k_y_v_per_dps":-0.00288092184583929,"k_z_v_per_dps":1.
 * document_json| 2699970204261855},"units":{"offset_v":"V","k_x_v_per_dps":"V/(deg/s)","k_y_v_per_dps":"V/(deg/s)","k
 * document_json| _z_v_per_dps":"V/(deg/s)"},"covariance":[[1.2932373047883707e-09,-9.388015082254007e-12,6.3704388058
 * document_json| 17189e-12,-5.699866299525569e-12],[-9.388015082254007e-12,8.510068660611838e-13,-2.3090249480884953e
 * document_json| -13,2.06596969024414e-13],[6.37043880581719e-12,-2.3090249480884953e-13,6.674133410535494e-13,-1.401
 * document_json| 9080040946717e-13],[-5.699866299525569e-12,2.06596969024414e-13,-1.4019080040946714e-13,6.3616337933
 * document_json| 17715e-13]],"tp_covariance":[[7.080708821794882e-10,0.0,0.0,0.0],[0.0,3.4966420466460703e-13,0.0,0.0
 * document_json| ],[0.0,0.0,3.4966420466460703e-13,0.0],[0.0,0.0,0.0,3.4966420466460703e-13]],"effective_degrees_of_f
 * document_json| reedom":{"offset_v":1.8102267017949538,"k_x_v_per_dps":1.3878757936621422,"k_y_v_per_dps":1.70315803
 * document_json| 15503463,"k_z_v_per_dps":1.821059250832855},"components":{"replications":{"covariance":[[2.590087891
 * document_json| 3888586e-10,-9.388015082254007e-12,6.370438805817189e-12,-5.699866299525569e-12],[-9.388015082254007
 * document_json| e-12,3.402773607708308e-13,-2.309024948088495e-13,2.06596969024414e-13],[6.37043880581719e-12,-2.309
 * document_json| 024948088495e-13,1.5668383576319634e-13,-1.4019080040946717e-13],[-5.699866299525569e-12,2.065969690
 * document_json| 24414e-13,-1.4019080040946714e-13,1.254338740414184e-13]],"degrees_of_freedom":1.0},"lack-of-fit":{"
 * document_json| covariance":[[1.0342285156494848e-09,1.3954271236795884e-28,3.9869974577290533e-29,1.395427123679584
 * document_json| 4e-28],[1.3954271236795884e-28,5.10729505290353e-13,-5.670236561287656e-29,0.0],[3.9869974577290533e
 * document_json| -29,-5.670236561287656e-29,5.107295052903531e-13,-5.821041551682308e-46],[1.3954271236795844e-28,0.0
 * document_json| ,-5.821041551682308e-46,5.107295052903532e-13]],"degrees_of_freedom":4.0}}},"sensitive_axis_v_per_g"
 * document_json| :{"x":null,"y":null,"z":null},"standard_error_v":0.00010643840526272369,"degrees_of_freedom":12,"rep
 * document_json| lication":{"n":2,"points":8,"lack_of_fit":{"t":3.9127288353986067,"f_95":6.3882329086958665,"p_value
 * document_json| ":0.10743337601107437,"numerator_dof":4.0,"denominator_dof":4.0,"is_significant":false},"drift":{"of
 * document_json| fset":{"t":0.7294542331128255,"f_95":7.708647422176786,"p_value":0.4411923697677693,"numerator_dof":
 * document_json| 1.0,"denominator_dof":4.0,"is_significant":false},"sensitivity":{"t":0.7190018662007462,"f_95":7.708
 * document_json| 647422176786,"p_value":0.44423070810751,"numerator_dof":1.0,"denominator_dof":4.0,"is_significant":f
 * document_json| alse},"coning":{"t":0.8972200362545911,"f_95":7.708647422176786,"p_value":0.397164059881933,"numerat
 * document_json| or_dof":1.0,"denominator_dof":4.0,"is_significant":false},"azimuth":{"t":1.9333440621043625,"f_95":7
 * document_json| .708647422176786,"p_value":0.23675922337321803,"numerator_dof":1.0,"denominator_dof":4.0,"is_signifi
 * document_json| cant":false}},"tp":{"sigma_bias_v":7.454664411343281e-05,"sigma_prec_v":5.421852485616929e-05,"t_bia
 * document_json| s":3.780861736753427,"f_bias_95":3.837853354555897,"drift":{"offset":{"t":0.2969649893382554,"f_95":
 * document_json| 5.317655071578713,"p_value":0.6006488771332286,"numerator_dof":1.0,"denominator_dof":8.0,"is_signifi
 * document_json| cant":false},"sensitivity":{"t":0.29270977115975627,"f_95":5.317655071578713,"p_value":0.60322387385
 * document_json| 19687,"numerator_dof":1.0,"denominator_dof":8.0,"is_significant":false},"coning":{"t":0.365263407085
 * document_json| 8405,"f_95":5.317655071578713,"p_value":0.5623413795367924,"numerator_dof":1.0,"denominator_dof":8.0
 * document_json| ,"is_significant":false},"azimuth":{"t":0.787075422593519,"f_95":5.317655071578713,"p_value":0.40086
 * document_json| 974202188747,"numerator_dof":1.0,"denominator_dof":8.0,"is_significant":false}}},"precision_v":7.537
 * document_json| 341934599685e-05,"lack_of_fit_v":9.096058555877853e-05,"per_replication":{"1":{"offset_v":0.05304031
 * document_json| 24999995,"sensitivity_v_per_dps":1.269999932990291,"coning_deg":0.12995486177856283,"azimuth_deg":0.
 * document_json| 14669376003644174},"2":{"offset_v":0.05300812499999475,"sensitivity_v_per_dps":1.2700006431245274,"c
 * document_json| oning_deg":0.1299906502976529,"azimuth_deg":0.16985274482422597}}},"warnings":[],"notes":{"condition
 * document_json| _number":1.0,"precision_variance_v2":5.6811523439074925e-09,"lack_of_fit_variance_v2":8.273828125195
 * document_json| 868e-09}}},"package":{"order":["x.offset_v","x.k_x_v_per_dps","x.k_y_v_per_dps","x.k_z_v_per_dps","y
 * document_json| .offset_v","y.k_x_v_per_dps","y.k_y_v_per_dps","y.k_z_v_per_dps","z.offset_v","z.k_x_v_per_dps","z.k
 * document_json| _y_v_per_dps","z.k_z_v_per_dps"],"components":{"replications":{"covariance":[[1.128906249768734e-10,
 * document_json| 5.386281421492666e-12,-4.1021393432744003e-25,6.86197496132124e-12,-1.6601562492284525e-11,-1.106770
 * document_json| 1550498046e-12,-8.927945917523594e-12,-7.083328992329932e-12,1.7099609375769976e-10,-6.1979128682888
 * document_json| 17e-12,4.205726589197284e-12,-3.7630185269017935e-12],[5.386281421492667e-12,2.5699235483425145e-13,
 * document_json| -1.9572286837440605e-26,3.2740121915778333e-13,-7.921002088371838e-13,-5.2806648251159544e-14,-4.259
 * document_json| 736292318334e-13,-3.3796254880795465e-13,8.158632155182042e-12,-2.9571723020696634e-13,2.00665263354
 * document_json| 78924e-13,-1.7954260404117735e-13],[-4.1021393432744003e-25,-1.9572286837440605e-26,1.49060625672742
 * document_json| 9e-39,-2.4934557202749303e-26,6.032557856188697e-26,4.021702774629687e-27,3.2441735715788856e-26,2.5
 * document_json| 738897757670626e-26,-6.213534595041848e-25,2.2521535537962257e-26,-1.5282470543621976e-26,1.36737894
 * document_json| 32768757e-26],[6.86197496132124e-12,3.2740121915778333e-13,-2.4934557202749303e-26,4.171001832919762
 * document_json| e-13,-1.0091139646379283e-12,-6.727422311148698e-14,-5.426787331067341e-13,-4.305550279141964e-13,1.
 * document_json| 0393873841069176e-11,-3.767356494249295e-13,2.556420478241384e-13,-2.2873235856279333e-13],[-1.66015
 * document_json| 62492284525e-11,-7.921002088371838e-13,6.032557856188697e-26,-1.0091139646379283e-12,2.4414062482308
 * document_json| 853e-12,1.6276031687678986e-13,1.312933222824022e-12,1.0416660280130996e-12,-2.514648436959711e-11,9
 * document_json| .114577745114807e-13,-6.184892041329818e-13,5.533850773417411e-13],[-1.1067701550498046e-12,-5.28066
 * document_json| 48251159544e-14,4.021702774629687e-27,-6.727422311148698e-14,1.6276031687678986e-13,1.08506811469943
 * document_json| 39e-14,8.752882792028214e-14,6.944435934087341e-14,-1.6764312646855346e-12,6.076381442326547e-14,-4.
 * document_json| 123258835865718e-14,3.689231589715779e-14],[-8.927945917523594e-12,-4.259736292318334e-13,3.24417357
 * document_json| 15788856e-26,-5.426787331067341e-13,1.312933222824022e-12,8.752882792028214e-14,7.06065878566578e-13
 * document_json| ,5.601844986906901e-13,-1.3523212201981191e-11,4.901614363543638e-13,-3.3260954609770687e-13,2.97598
 * document_json| 01490780066e-13],[-7.083328992329932e-12,-3.3796254880795465e-13,2.5738897757670626e-26,-4.305550279
 * document_json| 141964e-13,1.0416660280130996e-12,6.94443593408734e-14,5.6018449869069e-13,4.444438997822914e-13,-1.
 * document_json| 0729160094004359e-11,3.888884123095129e-13,-2.6388856549582253e-13,2.361108217421826e-13],[1.7099609
 * document_json| 375769976e-10,8.158632155182042e-12,-6.213534595041848e-25,1.0393873841069176e-11,-2.514648436959711
 * document_json| e-11,-1.6764312646855346e-12,-1.3523212201981191e-11,-1.0729160094004359e-11,2.5900878913888586e-10,
 * document_json| -9.388015082254007e-12,6.370438805817189e-12,-5.699866299525569e-12],[-6.197912868288817e-12,-2.9571
 * document_json| 723020696634e-13,2.2521535537962257e-26,-3.767356494249295e-13,9.114577745114807e-13,6.0763814423265
 * document_json| 47e-14,4.901614363543638e-13,3.888884123095129e-13,-9.388015082254007e-12,3.402773607708308e-13,-2.3
 * document_json| 09024948088495e-13,2.06596969024414e-13],[4.205726589197284e-12,2.0066526335478924e-13,-1.5282470543
 * document_json| 621976e-26,2.556420478241384e-13,-6.184892041329818e-13,-4.123258835865718e-14,-3.3260954609770687e-
 * document_json| 13,-2.6388856549582253e-13,6.37043880581719e-12,-2.309024948088495e-13,1.5668383576319634e-13,-1.401
 * document_json| 9080040946717e-13],[-3.7630185269017935e-12,-1.7954260404117735e-13,1.3673789432768757e-26,-2.287323
 * document_json| 5856279333e-13,5.533850773417411e-13,3.689231589715779e-14,2.9759801490780066e-13,2.361108217421826e
 * document_json| -13,-5.699866299525569e-12,2.06596969024414e-13,-1.4019080040946714e-13,1.254338740414184e-13]],"deg
 * document_json| rees_of_freedom":1.0},"lack-of-fit":{"covariance":[[0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0]
 * document_json| ,[0.0,0.0,-0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0],[0.0,-0.0,0.0,-0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0
 * document_json| .0],[0.0,0.0,-0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0],[0.0,0.0,0.0,0.0,2.8857421884038403e-10,3.893
 * document_json| 571740396653e-29,1.1124665965724496e-29,3.893571740396642e-29,-5.149588963141993e-10,7.4769590103392
 * document_json| 63e-29,-9.024648324660395e-29,-9.711627150765726e-29],[0.0,0.0,0.0,0.0,3.893571740396653e-29,1.42505
 * document_json| 61244227942e-13,-1.582130120717278e-29,0.0,2.4927627424441587e-29,-2.543003778949694e-13,2.823301347
 * document_json| 098732e-29,0.0],[0.0,0.0,0.0,0.0,1.1124665965724496e-29,-1.582130120717278e-29,1.4250561244227945e-1
 * document_json| 3,-1.6242082800813519e-46,-2.0860948135481737e-28,2.823301347098732e-29,-2.5430037789496943e-13,1.81
 * document_json| 8669380658824e-46],[0.0,0.0,0.0,0.0,3.893571740396642e-29,0.0,-1.6242082800813519e-46,1.425056124422
 * document_json| 7947e-13,1.8841751385728744e-28,0.0,1.8259910488259503e-46,-2.543003778949695e-13],[0.0,0.0,0.0,0.0,
 * document_json| -5.149588963141993e-10,2.4927627424441587e-29,-2.0860948135481737e-28,1.8841751385728744e-28,1.03422
 * document_json| 85156494848e-09,1.3954271236795884e-28,3.9869974577290533e-29,1.3954271236795844e-28],[0.0,0.0,0.0,0
 * document_json| .0,7.476959010339263e-29,-2.543003778949694e-13,2.823301347098732e-29,0.0,1.3954271236795884e-28,5.1
 * document_json| 0729505290353e-13,-5.670236561287656e-29,0.0],[0.0,0.0,0.0,0.0,-9.024648324660395e-29,2.823301347098
 * document_json| 732e-29,-2.5430037789496943e-13,1.8259910488259503e-46,3.9869974577290533e-29,-5.670236561287656e-29
 * document_json| ,5.107295052903531e-13,-5.821041551682308e-46],[0.0,0.0,0.0,0.0,-9.711627150765726e-29,0.0,1.8186693
 * document_json| 80658824e-46,-2.543003778949695e-13,1.3954271236795844e-28,0.0,-5.821041551682308e-46,5.107295052903
 * document_json| 532e-13]],"degrees_of_freedom":4.0}},"text":"order: axis.parameter; components: independent parts of
 * document_json|  the covariance of all primary parameters together, whose diagonal blocks are the axes' own"},"test_
 * document_json| vectors":{"tolerance_relative":1e-12,"tolerance_text":"outputs: of |offset_v| + |k_x| + |k_y| + |k_z
 * document_json| | of the axis; angles: of 180 degrees","forward":[{"pitch_deg":0.0,"roll_deg":0.0,"yaw_deg":0.0,"pit
 * document_json| ch_rate_dps":0.0,"yaw_rate_dps":0.0,"roll_rate_dps":0.0,"outputs_v":{"x":0.05100281249999718,"y":0.0
 * document_json| 51957812500002636,"z":0.053024218749997125}},{"pitch_deg":0.0,"roll_deg":0.0,"yaw_deg":0.0,"pitch_ra
 * document_json| te_dps":-36.000022,"yaw_rate_dps":0.0,"roll_rate_dps":-36.000022,"outputs_v":{"x":-44.94909136395358
 * document_json| 5,"y":-45.21295811352077,"z":0.15645096858096041}},{"pitch_deg":0.0,"roll_deg":0.0,"yaw_deg":0.0,"pi
 * document_json| tch_rate_dps":36.000022,"yaw_rate_dps":0.0,"roll_rate_dps":36.000022,"outputs_v":{"x":45.05109698895
 * document_json| 3574,"y":45.31687373852077,"z":-0.05040253108096617}},{"pitch_deg":0.0,"roll_deg":0.0,"yaw_deg":0.0,
 * document_json| "pitch_rate_dps":0.0,"yaw_rate_dps":-18.0000112,"roll_rate_dps":-18.0000112,"outputs_v":{"x":-22.405
 * document_json| 76890031705,"y":0.0993329379489645,"z":-22.807079622889326}},{"pitch_deg":0.0,"roll_deg":0.0,"yaw_de
 * document_json| g":0.0,"pitch_rate_dps":0.0,"yaw_rate_dps":18.0000112,"roll_rate_dps":18.0000112,"outputs_v":{"x":22
 * document_json| .507774525317046,"y":0.004582687051040764,"z":22.91312806038932}},{"pitch_deg":0.0,"roll_deg":0.0,"y
 * document_json| aw_deg":0.0,"pitch_rate_dps":15.120009200000002,"yaw_rate_dps":-26.640016400000004,"roll_rate_dps":2
 * document_json| 8.800017600000004,"outputs_v":{"x":36.11493903884626,"y":19.02693119608731,"z":-33.82304759816867}},
 * document_json| {"pitch_deg":0.0,"roll_deg":0.0,"yaw_deg":0.0,"pitch_rate_dps":-23.040014,"yaw_rate_dps":26.64001640
 * document_json| 0000004,"roll_rate_dps":-28.800017600000004,"outputs_v":{"x":-36.01297015384603,"y":-28.902198289377
 * document_json| 825,"z":33.95191295051613}},{"pitch_deg":0.0,"roll_deg":0.0,"yaw_deg":0.0,"pitch_rate_dps":-9.360005
 * document_json| 6,"yaw_rate_dps":8.640005200000001,"roll_rate_dps":7.200004400000001,"outputs_v":{"x":9.030212608017
 * document_json| 246,"y":-11.76056150199499,"z":11.05282782382687}},{"pitch_deg":0.0,"roll_deg":0.0,"yaw_deg":0.0,"pi
 * document_json| tch_rate_dps":30.9600188,"yaw_rate_dps":-6.480004,"roll_rate_dps":-14.400008800000002,"outputs_v":{"
 * document_json| x":-17.93327527301177,"y":39.09944661248235,"z":-8.265869548108094}}],"inverse":null,"inverse_text":
 * document_json| "none: it takes three axes in TP's convention, linear in the specific force, that together determine
 * document_json|  it"},"warnings":["2 replications only: intervals rest on 1 degrees of freedom and are wide; four or
 * document_json|  more make them much narrower"],"environment":{},"provenance":{"rig":"rate table, three axes","proce
 * document_json| dure":"gyro package, constant rates","operator":"tester","run_id":"20261122T095626Z-gyro-package-con
 * document_json| stant-rates","journal_sha256":"7a674be61af845f0d08187804a20fc33266b31897fb7e2bfc03706cd2678cb80","so
 * document_json| ftware_version":"0.1.0","created_utc":"2026-11-22T10:00:56.336521+00:00","standards":[],"mount":{"x"
 * document_json| :"+x","y":"+y","z":"+z","datum":""},"level":{"instrument":"","uncertainty_arcsec":0.0},"chain":{},"j
 * document_json| ob":{"number":"","customer":"","item":"","remarks":""},"acceptance":{"decision_rule":"guard-band"},"
 * document_json| laboratory":null},"checksum":{"algorithm":"SHA-256 of the document without this entry, as JSON with 
 * document_json| sorted keys, no spaces, UTF-8","sha256":"c89e2ac2564162e77a8b81520ea0f44dc28cfe68f3db5e6b478838e18d7
 * document_json| c3bb6"}}
 */
/* sha256 of all bytes above this line: ad8d17f418c15a4c9b658b31cf023f33ed86a3e6423146776787cbd7376357cf */
