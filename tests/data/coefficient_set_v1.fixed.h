/* calrig coefficient set as C header, fixed point, version 1
 * Loses: rounds coefficients to 2^-26 V and the force to 2^-30 (bound stated in the file), and holds
 *     the uncertainty only in its comment.
 * Axis x: the output is off by at most 2.898420299171422e-08 V, 0.0024 arc seconds where the axis is
 *     most sensitive to the angle.
 * Axis y: the output is off by at most 2.8964612738683332e-08 V, 0.0024 arc seconds where the axis is
 *     most sensitive to the angle.
 * Axis z: the output is off by at most 2.898222111177628e-08 V, 0.0024 arc seconds where the axis is
 *     most sensitive to the angle.
 * sensor: {"name": "SN1047", "serial": "1047", "model": "three-axis package"}; status: engineering
 * set: sha256 66873e5514e27816911d54be709f17ddb6f61bdead1c33c65af5c7ce789e9a6b, by calrig 0.1.0 on
 *     2026-03-01T06:20:00+00:00
 * convention TP: Package axes: x forward, y right, z down. Pitch alpha (nose up) about y, then roll R
 *     (right wing down) about x; no yaw. f = (sin alpha, -cos alpha sin R, -cos alpha cos R) in local
 *     g. Source: NASA/TP-1999-209835.
 * acceleration unit: local g = 9.79826 m/s^2 (survey 2024, u = 2e-6 m/s\xb2); units are the ends of
 *     the names
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
 * use: this set was written before sets said how to use them: ask who calibrated it
 */
#ifndef CALRIG_SN1047_FIXED_H
#define CALRIG_SN1047_FIXED_H 1
#include <stdint.h>

#define CALRIG_SN1047_FIXED_SET_SHA256 "66873e5514e27816911d54be709f17ddb6f61bdead1c33c65af5c7ce789e9a6b"
#define CALRIG_SN1047_FIXED_FORCE_BITS 30
#define CALRIG_SN1047_FIXED_VOLT_BITS 26
#define CALRIG_SN1047_FIXED_X_POLARITY 1
#define CALRIG_SN1047_FIXED_X_OFFSET 335544
#define CALRIG_SN1047_FIXED_X_K_X 167765772
#define CALRIG_SN1047_FIXED_X_K_Y 1199296
#define CALRIG_SN1047_FIXED_X_K_Z 839756
#define CALRIG_SN1047_FIXED_X_ERROR_V 2.898420299171422e-08
#define CALRIG_SN1047_FIXED_Y_POLARITY 1
#define CALRIG_SN1047_FIXED_Y_OFFSET (-812017)
#define CALRIG_SN1047_FIXED_Y_K_X (-776684)
#define CALRIG_SN1047_FIXED_Y_K_Y 165756468
#define CALRIG_SN1047_FIXED_Y_K_Z (-448419)
#define CALRIG_SN1047_FIXED_Y_ERROR_V 2.8964612738683332e-08
#define CALRIG_SN1047_FIXED_Z_POLARITY (-1)
#define CALRIG_SN1047_FIXED_Z_OFFSET 46976
#define CALRIG_SN1047_FIXED_Z_K_X 349831
#define CALRIG_SN1047_FIXED_Z_K_Y (-55408)
#define CALRIG_SN1047_FIXED_Z_K_Z (-169113966)
#define CALRIG_SN1047_FIXED_Z_ERROR_V 2.898222111177628e-08

/* f_x, f_y, f_z in 2^-30, x in 2^-26 V, y in 2^-26 V, z in 2^-26 V */
static const int32_t calrig_sn1047_fixed_vectors[9][6] = {
    {0, 0, -1073741824, -504212, -363598, 169160942},
    {-1073741824, 0, 0, -167430228, -35333, -302855},
    {1073741824, 0, 0, 168101316, -1588701, 396807},
    {0, 1073741824, 0, 1534840, 164944451, -8432},
    {0, -1073741824, 0, -863752, -166568485, 102384},
    {658103938, 618473374, 580785156, 104305384, 93944829, -91243986},
    {-906590207, -419404548, 393847086, -141474207, -65065350, -62257534},
    {-426434300, -674574299, -718348667, -67607540, -104339443, 113082518},
    {1047882644, 125506454, -197766526, 164046485, 17887371, 31530065},
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
 * document_json| {"format":"calrig coefficient set","version":1,"sensor":{"name":"SN1047","serial":"1047","model":"th
 * document_json| ree-axis package"},"status":"engineering","approved_by":null,"simulated":false,"acceleration_unit":{
 * document_json| "name":"local g","value_mps2":9.79826,"source":"survey 2024, u = 2e-6 m/s\u00b2"},"validity":{"pitch
 * document_json| _deg":[-90.0,90.0],"roll_deg":[-180.0,180.0],"temperature_degc":[19.0,21.0]},"model":"pitch-roll","c
 * document_json| onvention":{"name":"TP","text":"Package axes: x forward, y right, z down. Pitch alpha (nose up) abou
 * document_json| t y, then roll R (right wing down) about x; no yaw. f = (sin alpha, -cos alpha sin R, -cos alpha cos
 * document_json|  R) in local g. Source: NASA/TP-1999-209835."},"inputs":["pitch_deg","roll_deg"],"axes":{"x":{"nomin
 * document_json| al_axis":"x","equation":{"name":"pitch-roll","source":"TP (2)","primary":"output = offset_v + k_x_v_
 * document_json| per_g\u002af_x + k_y_v_per_g\u002af_y + k_z_v_per_g\u002af_z","derived":"v = b + S\u002a(cos W sin a
 * document_json| lpha - sin W cos alpha sin(R + A)); alpha = pitch_deg, R = roll_deg, b = offset_v, S = sensitivity_v
 * document_json| _per_g, W = coning_deg, A = azimuth_deg"},"parameters":{"offset_v":{"value":0.005,"unit":"V","standa
 * document_json| rd_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_9
 * document_json| 5":[0.004998,0.005002]},"sensitivity_v_per_g":{"value":2.5,"unit":"V/g","standard_uncertainty":1e-06
 * document_json| ,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[2.499998,2.500002
 * document_json| ]},"coning_deg":{"value":0.5,"unit":"deg","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-
 * document_json| 07,"effective_degrees_of_freedom":5.2,"interval_95":[0.499998,0.500002]},"azimuth_deg":{"value":35.0
 * document_json| ,"unit":"deg","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_fre
 * document_json| edom":5.2,"interval_95":[34.999998,35.000002]}},"covariance_order":["offset_v","sensitivity_v_per_g"
 * document_json| ,"coning_deg","azimuth_deg"],"covariance":[[1e-12,0.0,0.0,0.0],[0.0,2e-12,0.0,0.0],[0.0,0.0,1e-09,0.
 * document_json| 0],[0.0,0.0,0.0,0.001]],"primary":{"order":["offset_v","k_x_v_per_g","k_y_v_per_g","k_z_v_per_g"],"v
 * document_json| alues":{"offset_v":0.005,"k_x_v_per_g":2.499904807660428,"k_y_v_per_g":0.017870898482633662,"k_z_v_p
 * document_json| er_g":0.012513337832120552},"units":{"offset_v":"V","k_x_v_per_g":"V/g","k_y_v_per_g":"V/g","k_z_v_p
 * document_json| er_g":"V/g"},"covariance":[[1.1e-12,1e-13,1e-13,1e-13],[1e-13,2.1e-12,1e-13,1e-13],[1e-13,1e-13,2.1e
 * document_json| -12,1e-13],[1e-13,1e-13,1e-13,2.1e-12]],"tp_covariance":[[9.9e-13,9.000000000000001e-14,9.0000000000
 * document_json| 00001e-14,9.000000000000001e-14],[9.000000000000001e-14,1.89e-12,9.000000000000001e-14,9.00000000000
 * document_json| 0001e-14],[9.000000000000001e-14,9.000000000000001e-14,1.89e-12,9.000000000000001e-14],[9.0000000000
 * document_json| 00001e-14,9.000000000000001e-14,9.000000000000001e-14,1.89e-12]],"effective_degrees_of_freedom":{"of
 * document_json| fset_v":5.2,"k_x_v_per_g":5.3,"k_y_v_per_g":6.1,"k_z_v_per_g":null},"components":{"replications":{"c
 * document_json| ovariance":[[1e-12,0.0,0.0,0.0],[0.0,2e-12,0.0,0.0],[0.0,0.0,2e-12,0.0],[0.0,0.0,0.0,2e-12]],"degree
 * document_json| s_of_freedom":5.0},"table":{"covariance":[[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13],[1e-13
 * document_json| ,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13]],"degrees_of_freedom":null}}},"sensitive_axis_v_per_g"
 * document_json| :{"x":2.499904807660428,"y":0.017870898482633662,"z":0.012513337832120552},"standard_error_v":2e-05,
 * document_json| "degrees_of_freedom":490,"replication":{"n":2,"points":247,"lack_of_fit":{"t":0.98,"f_95":1.16,"p_va
 * document_json| lue":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,"is_significant":false},"drift":{"offset":{"
 * document_json| t":1.1,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,"is_significant":fal
 * document_json| se},"sensitivity":{"t":1.1,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,
 * document_json| "is_significant":false},"coning":{"t":1.1,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"denominat
 * document_json| or_dof":1215.0,"is_significant":false},"azimuth":{"t":1.1,"f_95":1.16,"p_value":0.2,"numerator_dof":
 * document_json| 243.0,"denominator_dof":1215.0,"is_significant":false}},"tp":{"sigma_bias_v":4.17e-05,"sigma_prec_v"
 * document_json| :1.54e-05,"t_bias":37.3,"f_bias_95":1.16,"drift":{"offset":{"t":1.1,"f_95":1.16,"p_value":0.2,"numer
 * document_json| ator_dof":243.0,"denominator_dof":1215.0,"is_significant":false},"sensitivity":{"t":1.1,"f_95":1.16,
 * document_json| "p_value":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,"is_significant":false},"coning":{"t":1
 * document_json| .1,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,"is_significant":false},
 * document_json| "azimuth":{"t":1.1,"f_95":1.16,"p_value":0.2,"numerator_dof":243.0,"denominator_dof":1215.0,"is_sign
 * document_json| ificant":false}}},"precision_v":2e-05,"lack_of_fit_v":1e-05,"per_replication":{"1":{"offset_v":0.005
 * document_json| ,"sensitivity_v_per_g":2.5,"coning_deg":0.5,"azimuth_deg":35.0},"2":{"offset_v":0.005,"sensitivity_v
 * document_json| _per_g":2.5,"coning_deg":0.5,"azimuth_deg":35.0}}},"warnings":[],"notes":{}},"y":{"nominal_axis":"y"
 * document_json| ,"equation":{"name":"pitch-roll","source":"TP (4)","primary":"output = offset_v + k_x_v_per_g\u002af
 * document_json| _x + k_y_v_per_g\u002af_y + k_z_v_per_g\u002af_z","derived":"v = b + S\u002a(-cos W cos alpha sin R 
 * document_json| + sin W (sin A sin alpha - cos A cos alpha cos R)); alpha = pitch_deg, R = roll_deg, b = offset_v, S
 * document_json|  = sensitivity_v_per_g, W = coning_deg, A = azimuth_deg"},"parameters":{"offset_v":{"value":-0.0121,
 * document_json| "unit":"V","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedo
 * document_json| m":5.2,"interval_95":[-0.012102,-0.012098]},"sensitivity_v_per_g":{"value":2.47,"unit":"V/g","standa
 * document_json| rd_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_9
 * document_json| 5":[2.4699980000000004,2.470002]},"coning_deg":{"value":0.31,"unit":"deg","standard_uncertainty":1e-
 * document_json| 06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[0.309998,0.3100
 * document_json| 02]},"azimuth_deg":{"value":-120.0,"unit":"deg","standard_uncertainty":1e-06,"tp_standard_uncertaint
 * document_json| y":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[-120.000002,-119.999998]}},"covariance_or
 * document_json| der":["offset_v","sensitivity_v_per_g","coning_deg","azimuth_deg"],"covariance":[[1e-12,0.0,0.0,0.0]
 * document_json| ,[0.0,2e-12,0.0,0.0],[0.0,0.0,1e-09,0.0],[0.0,0.0,0.0,0.001]],"primary":{"order":["offset_v","k_x_v_
 * document_json| per_g","k_y_v_per_g","k_z_v_per_g"],"values":{"offset_v":-0.0121,"k_x_v_per_g":-0.011573494976522679
 * document_json| ,"k_y_v_per_g":2.4699638470266536,"k_z_v_per_g":-0.006681960440160146},"units":{"offset_v":"V","k_x_
 * document_json| v_per_g":"V/g","k_y_v_per_g":"V/g","k_z_v_per_g":"V/g"},"covariance":[[1.1e-12,1e-13,1e-13,1e-13],[1
 * document_json| e-13,2.1e-12,1e-13,1e-13],[1e-13,1e-13,2.1e-12,1e-13],[1e-13,1e-13,1e-13,2.1e-12]],"tp_covariance":[
 * document_json| [9.9e-13,9.000000000000001e-14,9.000000000000001e-14,9.000000000000001e-14],[9.000000000000001e-14,1
 * document_json| .89e-12,9.000000000000001e-14,9.000000000000001e-14],[9.000000000000001e-14,9.000000000000001e-14,1.
 * document_json| 89e-12,9.000000000000001e-14],[9.000000000000001e-14,9.000000000000001e-14,9.000000000000001e-14,1.8
 * document_json| 9e-12]],"effective_degrees_of_freedom":{"offset_v":5.2,"k_x_v_per_g":5.3,"k_y_v_per_g":6.1,"k_z_v_pe
 * document_json| r_g":null},"components":{"replications":{"covariance":[[1e-12,0.0,0.0,0.0],[0.0,2e-12,0.0,0.0],[0.0,
 * document_json| 0.0,2e-12,0.0],[0.0,0.0,0.0,2e-12]],"degrees_of_freedom":5.0},"table":{"covariance":[[1e-13,1e-13,1e
 * document_json| -13,1e-13],[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13]],"degrees_o
 * document_json| f_freedom":null}}},"sensitive_axis_v_per_g":{"x":-0.011573494976522679,"y":2.4699638470266536,"z":-0
 * document_json| .006681960440160146},"standard_error_v":2e-05,"degrees_of_freedom":490,"replication":null,"warnings"
 * document_json| :[],"notes":{}},"z":{"nominal_axis":"z","equation":{"name":"pitch-roll","source":"TP (5)","primary":
 * document_json| "output = offset_v + k_x_v_per_g\u002af_x + k_y_v_per_g\u002af_y + k_z_v_per_g\u002af_z","derived":"
 * document_json| v = b + S\u002a(-cos W cos alpha cos R + sin W (cos A sin alpha - sin A cos alpha sin R)); alpha = p
 * document_json| itch_deg, R = roll_deg, b = offset_v, S = sensitivity_v_per_g, W = coning_deg, A = azimuth_deg"},"pa
 * document_json| rameters":{"offset_v":{"value":0.0007,"unit":"V","standard_uncertainty":1e-06,"tp_standard_uncertain
 * document_json| ty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[0.0006979999999999999,0.000702]},"sensit
 * document_json| ivity_v_per_g":{"value":-2.52,"unit":"V/g","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e
 * document_json| -07,"effective_degrees_of_freedom":5.2,"interval_95":[-2.520002,-2.519998]},"coning_deg":{"value":0.
 * document_json| 12,"unit":"deg","standard_uncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_f
 * document_json| reedom":5.2,"interval_95":[0.119998,0.120002]},"azimuth_deg":{"value":171.0,"unit":"deg","standard_u
 * document_json| ncertainty":1e-06,"tp_standard_uncertainty":9e-07,"effective_degrees_of_freedom":5.2,"interval_95":[
 * document_json| 170.999998,171.000002]}},"covariance_order":["offset_v","sensitivity_v_per_g","coning_deg","azimuth_
 * document_json| deg"],"covariance":[[1e-12,0.0,0.0,0.0],[0.0,2e-12,0.0,0.0],[0.0,0.0,1e-09,0.0],[0.0,0.0,0.0,0.001]]
 * document_json| ,"primary":{"order":["offset_v","k_x_v_per_g","k_y_v_per_g","k_z_v_per_g"],"values":{"offset_v":0.00
 * document_json| 07,"k_x_v_per_g":0.005212892439495184,"k_y_v_per_g":-0.0008256410515014521,"k_z_v_per_g":-2.51999447
 * document_json| 3023556},"units":{"offset_v":"V","k_x_v_per_g":"V/g","k_y_v_per_g":"V/g","k_z_v_per_g":"V/g"},"covar
 * document_json| iance":[[1.1e-12,1e-13,1e-13,1e-13],[1e-13,2.1e-12,1e-13,1e-13],[1e-13,1e-13,2.1e-12,1e-13],[1e-13,1
 * document_json| e-13,1e-13,2.1e-12]],"tp_covariance":[[9.9e-13,9.000000000000001e-14,9.000000000000001e-14,9.0000000
 * document_json| 00000001e-14],[9.000000000000001e-14,1.89e-12,9.000000000000001e-14,9.000000000000001e-14],[9.000000
 * document_json| 000000001e-14,9.000000000000001e-14,1.89e-12,9.000000000000001e-14],[9.000000000000001e-14,9.0000000
 * document_json| 00000001e-14,9.000000000000001e-14,1.89e-12]],"effective_degrees_of_freedom":{"offset_v":5.2,"k_x_v_
 * document_json| per_g":5.3,"k_y_v_per_g":6.1,"k_z_v_per_g":null},"components":{"replications":{"covariance":[[1e-12,
 * document_json| 0.0,0.0,0.0],[0.0,2e-12,0.0,0.0],[0.0,0.0,2e-12,0.0],[0.0,0.0,0.0,2e-12]],"degrees_of_freedom":5.0},
 * document_json| "table":{"covariance":[[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13],[1e-13,1e-13,1e-13,1e-13]
 * document_json| ,[1e-13,1e-13,1e-13,1e-13]],"degrees_of_freedom":null}}},"sensitive_axis_v_per_g":{"x":0.00521289243
 * document_json| 9495184,"y":-0.0008256410515014521,"z":-2.519994473023556},"standard_error_v":2e-05,"degrees_of_free
 * document_json| dom":490,"replication":null,"warnings":[],"notes":{}}},"test_vectors":{"tolerance_relative":1e-12,"t
 * document_json| olerance_text":"outputs: of |offset_v| + |k_x| + |k_y| + |k_z| of the axis; angles: of 180 degrees",
 * document_json| "forward":[{"pitch_deg":0.0,"roll_deg":0.0,"outputs_v":{"x":-0.007513337832120552,"y":-0.00541803955
 * document_json| 9839854,"z":2.520694473023556}},{"pitch_deg":-90.0,"roll_deg":0.0,"outputs_v":{"x":-2.49490480766042
 * document_json| 83,"y":-0.0005265050234773208,"z":-0.00451289243949503}},{"pitch_deg":90.0,"roll_deg":0.0,"outputs_v
 * document_json| ":{"x":2.504904807660428,"y":-0.02367349497652268,"z":0.005912892439495339}},{"pitch_deg":0.0,"roll_
 * document_json| deg":-90.0,"outputs_v":{"x":0.022870898482633663,"y":2.457863847026654,"z":-0.0001256410515012978}},
 * document_json| {"pitch_deg":0.0,"roll_deg":90.0,"outputs_v":{"x":-0.012870898482633661,"y":-2.4820638470266534,"z":
 * document_json| 0.0015256410515016063}},{"pitch_deg":37.8,"roll_deg":-133.2,"outputs_v":{"x":1.5542713391973593,"y":
 * document_json| 1.3998870286319793,"z":-1.359641343624537}},{"pitch_deg":-57.6,"roll_deg":133.2,"outputs_v":{"x":-2.
 * document_json| 1081299538299367,"y":-0.9695492683725558,"z":-0.9277095453050531}},{"pitch_deg":-23.4,"roll_deg":43.
 * document_json| 2,"outputs_v":{"x":-1.0074308488395782,"y":-1.554778864849105,"z":1.685060830132667}},{"pitch_deg":7
 * document_json| 7.4,"roll_deg":-32.4,"outputs_v":{"x":2.4444831186468146,"y":0.26654259441700356,"z":0.4698345892123
 * document_json| 24}}],"inverse":[{"pitch_deg":0.0,"roll_deg":0.0,"outputs_v":{"x":-0.007513337832120552,"y":-0.00541
 * document_json| 8039559839854,"z":2.520694473023556}},{"pitch_deg":0.0,"roll_deg":-90.0,"outputs_v":{"x":0.022870898
 * document_json| 482633663,"y":2.457863847026654,"z":-0.0001256410515012978}},{"pitch_deg":0.0,"roll_deg":90.0,"outpu
 * document_json| ts_v":{"x":-0.012870898482633661,"y":-2.4820638470266534,"z":0.0015256410515016063}},{"pitch_deg":37
 * document_json| .8,"roll_deg":-133.2,"outputs_v":{"x":1.5542713391973593,"y":1.3998870286319793,"z":-1.3596413436245
 * document_json| 37}},{"pitch_deg":-57.6,"roll_deg":133.2,"outputs_v":{"x":-2.1081299538299367,"y":-0.969549268372555
 * document_json| 8,"z":-0.9277095453050531}},{"pitch_deg":-23.4,"roll_deg":43.2,"outputs_v":{"x":-1.0074308488395782,
 * document_json| "y":-1.554778864849105,"z":1.685060830132667}},{"pitch_deg":77.4,"roll_deg":-32.4,"outputs_v":{"x":2
 * document_json| .4444831186468146,"y":0.26654259441700356,"z":0.469834589212324}}],"inverse_text":"K has one row (k_
 * document_json| x, k_y, k_z) for each axis; f = K^-1 (outputs - offsets) (offsets and K at the temperature); pitch =
 * document_json|  atan2(f_x, sqrt(f_y^2 + f_z^2)); roll = atan2(-f_y, -f_z)"},"warnings":[],"environment":{"air":{"me
 * document_json| an_degc":20.02,"min_degc":19.6,"max_degc":20.4}},"provenance":{"rig":"accelerometer laboratory, dual
 * document_json| -axis table","procedure":"three-axis, \u00b190\u00b0, six replications","operator":"J. Doe","run_id"
 * document_json| :"20260228T190000Z-three-axis","journal_sha256":"0123456789abcdef0123456789abcdef0123456789abcdef012
 * document_json| 3456789abcdef","software_version":"0.1.0","created_utc":"2026-03-01T06:20:00+00:00","standards":[{"n
 * document_json| ame":"table","serial":"77","certificate":"C-2025-14","due":"2027-01-31","uncertainty":{"limit_arcsec
 * document_json| ":1.0,"kind":"limit"}},{"name":"meter","serial":"2823A","certificate":null,"due":null,"uncertainty":
 * document_json| null}],"mount":{"x":"+pitch","datum":"face A"},"level":null,"chain":{"x":{"load_resistor_ohm":2500,"
 * document_json| ratiometric":false}},"job":{"customer":"=HYPERLINK(\"http://example.invalid\")","item":"-1\r\n\u0040
 * document_json| x"},"acceptance":null,"laboratory":{"name":"Instrument Laboratory"}},"checksum":{"algorithm":"SHA-25
 * document_json| 6 of the document without this entry, as JSON with sorted keys, no spaces, UTF-8","sha256":"66873e55
 * document_json| 14e27816911d54be709f17ddb6f61bdead1c33c65af5c7ce789e9a6b"}}
 */
/* sha256 of all bytes above this line: 9dd7ead6674065824eaa1b0db0308b5f83995d8e0d2f8b697e6a5ce9368e23c9 */
