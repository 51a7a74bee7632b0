/* This header makes a lumen whose wall is known in closed form, for tests and benchmarks: a tube of one
 * radius around a path of straight pieces and arcs. The distance is exact (double). The distance field is the
 * one that the scene baker would store, but this code computes it independently of the baker. */
#ifndef CRN_REFERENCE_TUBE_LUMEN_H
#define CRN_REFERENCE_TUBE_LUMEN_H

#include "firmware/core/core.h"

typedef struct reference_tube {
    double (*points_m)[3]; /* path, finely sampled */
    uint32_t point_count;
    uint32_t branch; /* first point of a second path, which starts where the trunk ends; 0: none */
    double radius_m;
    double throat_m, throat_at_m,
        throat_length_m; /* length of the cosine-shaped stenosis in a straight tube; 0: there is none */
    crn_lumen lumen;     /* it owns index, children and samples */
} reference_tube;

/* A piece of the tube's path is a straight line of `length_m` along the current direction, or an arc of
 * `angle_rad` and radius `length_m / angle_rad`. An arc of the path bends towards the current normal, which
 * is first turned by `roll_rad` about the direction. */
typedef struct reference_piece {
    double length_m, angle_rad, roll_rad;
} reference_piece;

/* The tube's path starts at the origin along +x with the normal +z. The distance field has the refinement
 * `level` (0 .. 2) within about 3 voxels of the wall. */
reference_tube *reference_tube_make(const reference_piece *pieces, uint32_t piece_count, double radius_m,
                                    uint32_t level);
/* Makes a tube that forks in two: the pieces `left` and `right` continue from the trunk's end. */
reference_tube *reference_fork_make(const reference_piece *trunk, const reference_piece left[2],
                                    const reference_piece right[2], double radius_m, uint32_t level);
/* Makes a straight tube with a stenosis whose middle is `at_m` along the tube. The tube's radius in the
 * stenosis is radius_m - (radius_m - throat_m) (1 + cos(2 pi u)) / 2, where u is the distance along the tube
 * from the stenosis' middle, divided by length_m. */
reference_tube *reference_stenosis_make(double tube_m, double radius_m, double throat_m, double at_m,
                                        double length_m, uint32_t level);
void reference_tube_free(reference_tube *tube);

/* Returns the exact signed distance to the wall in metres, negative inside the lumen. */
double reference_tube_distance(const reference_tube *tube, const double *point_m);

/* Standard scenes. In all standard scenes of this header, the tools enter at the origin in the direction +x.
 */
crn_entry reference_entry(void);
/* Makes a uniform instrument of bending stiffness EI (in N m^2) with elements of `element_um` and equal
 * kinetic and static friction. */
crn_instrument reference_wire(double bend_N_m2, uint32_t length_um, uint32_t element_um, double friction);
/* Makes a wire like reference_wire, but of 0.9 m and with a soft J-shaped tip of 12 mm, which snaps from wall
 * to wall. */
crn_instrument reference_floppy_j(double bend_N_m2);
/* Makes the scene of the insertion: a tube of 0.9 m length and 4 mm radius, with three bends that do not lie
 * in one plane. */
reference_tube *reference_three_bends(double radius_m, uint32_t level);

#endif
