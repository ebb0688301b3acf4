# Written by `python tools/generate.py stubs` from the declarations of the filters; change those instead.
"""The filters of plugins as methods, for `MeshSet` to inherit."""

from collections.abc import Sequence
from typing import Any, Literal

from .methods import LengthLike

class FilterMethods:
    """One method for each filter of a plugin."""

    def __getattr__(self, name: str) -> Any: ...
    def apply_color_anisotropic_diffusion_per_vertex(
        self,
        *,
        range_kernel: Literal["lorentzian", "gaussian", "tukey", "huber", "hampel", "truncated_l2", "l2"] = "lorentzian",
        range_sigma: float = 0.0,
        step: float = 1.0,
        iterations: int = 10,
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths the vertex colours over the mesh and keeps their edges, the same for red, green and blue. Opacity stays.

        Args:
            range_kernel: How the flow between neighbours falls with their difference. 'lorentzian' and 'gaussian' are the
                paper's, 1 / (1 + x^2) and exp(-x^2); 'tukey', 'hampel' and 'truncated_l2' stop it at edges; 'huber' slows it,
                'l2' does not.
            range_sigma: Differences between neighbouring colours above it are edges, and stay; 1.73 is from black to white.
                Larger smooths stronger noise and blurs more edges. 0: from the median difference. Takes a number of at least 0.
            step: The share of the largest stable step, which is one over the largest number of neighbours of a vertex. Larger
                is smoother per iteration. Takes a number from 0 to 1.
            iterations: How many steps are taken. More are smoother and slower. Takes a whole number from 0 to 100000.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [perona1990], [black1998]

        In scripts: 'Anisotropic Diffusion of Vertex Colors'.
        """

    def apply_coord_bilaplacian_smoothing(
        self,
        *,
        detail_size: LengthLike = "6edge",
        weight: float = 0.0,
        features: Literal["none", "curvature", "scalar"] = "none",
        feature_angle: float = 30.0,
        feature_scalar: float = 1.0,
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths by trading the bending of the surface for the distance that its vertices move: (C M^-1 W C + w M) p' = w M p.

        W is 1, or nearly 0 at features, where the surface may bend. Against implicit fairing at the same detail size, shorter
        waves are damped more and longer ones kept better, so that shapes shrink far less. Returns w in one over the fourth
        power of mesh units (0 or infinite where no number is so small or large), how many vertices moved and how far the
        furthest went.

        Args:
            detail_size: Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay.
                Larger is smoother. Not used when a weight is given. Takes a length such as '1%' (of the bounding box's
                diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            weight: How strongly vertices are held to their places, w, in one over the fourth power of mean edges. Larger stays
                closer to the input: 0.02 smooths strongly, 0.2 mildly. 0: not used, the detail size decides. Takes a number of
                at least 0.
            features: What is spared. 'none': every place is smoothed alike; 'curvature': ridges, found where the surface bends
                by more than an angle, may stay sharp; 'scalar': places of a high vertex scalar are spared.
            feature_angle: For 'curvature', the angle between neighbouring triangles, in degrees, at which a ridge counts half;
                noise is filtered out before. Larger spares sharper ridges alone. Takes a number from 1 to 179.
            feature_scalar: For 'scalar', the size of the vertex scalar at which smoothing counts half, as 1 / (1 + (q /
                this)^2). Larger spares higher values alone. Takes a number from 1e-30 to 1e+30.
            border: What the vertices of open borders do: 'fixed' stay; 'along' are smoothed as a curve, seeing their neighbours
                on the border alone; 'free' move like any other vertex, so that borders recede.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [nealen2006], [zheng2011]

        In scripts: 'Bi-Laplacian Smoothing'.
        """

    def apply_coord_bilateral_fleishman(
        self,
        *,
        range_kernel: Literal[
            "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "gaussian",
        space_kernel: Literal[
            "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "gaussian",
        range_sigma: LengthLike = "0",
        space_sigma: LengthLike = "0",
        iterations: int = 2,
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes noise and keeps features: every vertex moves along its normal to the mean height of neighbours that roughly
        agree.

        Fast, and enough for light noise; triangles keep their shape. The surface shrinks a little with each iteration.

        Args:
            range_kernel: How a neighbour counts that disagrees. With 'gaussian', 'tukey', 'hampel', 'lorentzian' and the
                truncated kernels it counts little or nothing far beyond the range sigma: features stay. 'huber' and 'l1'
                respect them less, 'l2' not at all.
            space_kernel: How neighbours count by their distance; beyond 1.4 times the space sigma none does. 'gaussian' is the
                paper's, 'l2' counts all alike, 'l1' favours the nearest.
            range_sigma: Differences in height below it are taken for noise, larger ones for features. Larger removes stronger
                noise, and flattens larger features. 0: estimated from the mesh. Takes a length such as '1%' (of the bounding
                box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            space_sigma: How far away neighbours count. Larger averages over more, is smoother and slower. 0: 1.4 mean edges.
                Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            iterations: How many steps are taken. More are smoother, slower, and shrink more. Takes a whole number from 0 to
                10000.
            border: What the vertices of open borders do: 'fixed' stay; 'along' see their neighbours on the border alone; 'free'
                see all of their neighbours.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [fleishman2003]

        In scripts: 'Bilateral Denoising along Normals (Fleishman)'.
        """

    def apply_coord_bilateral_jones(
        self,
        *,
        range_kernel: Literal[
            "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "gaussian",
        space_kernel: Literal[
            "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "gaussian",
        range_sigma: LengthLike = "0",
        space_sigma: LengthLike = "0",
        border: Literal["fixed", "free"] = "free",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes noise and keeps features in one step: every vertex goes to the mean of its projections to the planes of
        triangles.

        Near triangles that roughly agree count most. Triangles are found by place, so that non-manifold meshes and loose
        triangles are filtered too; curved surfaces shrink less than along normals.

        Args:
            range_kernel: How a neighbour counts that disagrees. With 'gaussian', 'tukey', 'hampel', 'lorentzian' and the
                truncated kernels it counts little or nothing far beyond the range sigma: features stay. 'huber' and 'l1'
                respect them less, 'l2' not at all.
            space_kernel: How neighbours count by their distance; beyond 1.4 times the space sigma none does. 'gaussian' is the
                paper's, 'l2' counts all alike, 'l1' favours the nearest.
            range_sigma: Differences in height below it are taken for noise, larger ones for features. Larger removes stronger
                noise, and flattens larger features. 0: estimated from the mesh. Takes a length such as '1%' (of the bounding
                box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            space_sigma: How far away triangles count. Larger averages over more, is smoother and slower. 0: 2 mean edges. Takes
                a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            border: What the vertices of open borders do: 'fixed' stay; 'free' move like any other vertex.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [jones2003]

        In scripts: 'Bilateral Denoising by Triangle Predictors (Jones)'.
        """

    def apply_coord_bilateral_projection_of_points(
        self,
        *,
        neighbors: int = 18,
        range_kernel: Literal[
            "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "gaussian",
        space_kernel: Literal[
            "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "gaussian",
        range_sigma: LengthLike = "0",
        space_sigma: LengthLike = "0",
        iterations: int = 2,
        use_normals: bool = False,
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes noise from a point cloud: every point moves along its normal to the mean height of neighbours that roughly
        agree.

        Triangles, if there are any, play no part. The normals themselves are not changed: compute them anew afterwards.

        Args:
            neighbors: How many nearest points count. More are smoother, slower, and round off edges. Takes a whole number of at
                least 3.
            range_kernel: How a neighbour counts that disagrees. With 'gaussian', 'tukey', 'hampel', 'lorentzian' and the
                truncated kernels it counts little or nothing far beyond the range sigma: features stay. 'huber' and 'l1'
                respect them less, 'l2' not at all.
            space_kernel: How neighbours count by their distance; beyond 1.4 times the space sigma none does. 'gaussian' is the
                paper's, 'l2' counts all alike, 'l1' favours the nearest.
            range_sigma: Differences in height below it are taken for noise, larger ones for features. Larger removes stronger
                noise, and flattens larger features. 0: estimated from the mesh. Takes a length such as '1%' (of the bounding
                box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            space_sigma: How neighbours count by their distance. Larger weighs distant ones more like near ones. 0: from the
                mean distance of the farthest neighbour. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge'
                or '0.3' (mesh units) of at least 0.0.
            iterations: How many steps are taken. More are smoother, slower, and shrink more. Takes a whole number from 0 to
                10000.
            use_normals: Move along the normals that the points have, in all iterations. Otherwise normals are estimated from
                the same neighbours, anew in each iteration.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [fleishman2003]

        In scripts: 'Bilateral Projection of Points'.
        """

    def apply_coord_curve_smoothing(
        self,
        *,
        method: Literal["explicit", "implicit", "taubin"] = "implicit",
        weights: Literal["uniform", "inverse_length"] = "inverse_length",
        detail_size: LengthLike = "12edge",
        time_step: float = 0.0,
        step: float = 0.5,
        mu: float = -0.53,
        pass_band: float = 0.0,
        iterations: int = 10,
        border: Literal["fixed", "free"] = "fixed",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths polylines: sections, contours, borders; open or closed, several in one layer, in the plane or in space.

        Planar curves stay in their plane. Where a curve branches, a vertex goes towards the mean of all its neighbours. Faces
        of the same layer are not looked at.

        Args:
            method: 'explicit': every vertex goes a step towards its neighbours; closed curves shrink. 'implicit': waves below
                the detail size vanish, in steps that are stable however long; closed curves shrink a little. 'taubin': a step
                and a longer one back, so that curves keep their size.
            weights: 'inverse_length': near neighbours pull more, so that uneven sampling stays as it is and straight parts do
                not move. 'uniform': all neighbours pull alike, which evens out the distances along the curve.
            detail_size: Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay.
                Larger is smoother. Mean edges are those of the curves. For 'implicit' with 'inverse_length'; not used when a
                time step is given. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units) of at least 0.0.
            time_step: For 'implicit': how strong one iteration is, a pure number; with uniform weights it must be given. Larger
                is smoother; any value is stable. 0: not used, the detail size decides. Takes a number of at least 0.
            step: For 'explicit' and 'taubin': the share of the way towards the neighbours' mean that a vertex goes, above 0.
                Larger is smoother. Takes a number from 0 to 1.
            mu: For 'taubin': the step back, below minus the first one. Nearer to -lambda is smoother; not used when a pass band
                is given. Takes a number from -1.5 to 0.
            pass_band: For 'taubin': frequencies below it are kept, above it damped; on a closed curve of n vertices a wave that
                runs m times round it has 1 - cos(2 pi m / n). Smaller is smoother. 0: not used, mu decides. Takes a number from
                0 to 2.
            iterations: How many steps. More are smoother; with a detail size they cut off more sharply instead. Takes a whole
                number from 1 to 100000.
            border: What the ends of open curves do: 'fixed' stay; 'free' draw in towards their neighbours.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [taubin1995], [desbrun1999]

        In scripts: 'Curve Smoothing'.
        """

    def apply_coord_explicit_smoothing(
        self,
        *,
        operator: Literal["uniform", "inverse_length", "scale_dependent", "cotangent", "laplace_beltrami", "robust"] = "uniform",
        step: float = 0.5,
        iterations: int = 10,
        update: Literal["euler", "meshlab"] = "euler",
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Moves every vertex towards the weighted mean of its neighbours, all at once, again and again.

        Simple and fast, but closed surfaces shrink: use Taubin Fairing to keep the volume, or Implicit Fairing for strong
        smoothing in one step.

        Args:
            operator: How neighbours are weighted. 'uniform' evens out triangle sizes and drifts along the surface;
                'inverse_length' keeps uneven sampling; 'scale_dependent' does so in true lengths; 'cotangent' moves vertices
                along the normal and leaves flat parts alone; 'laplace_beltrami' is the same in true units, the mean curvature
                flow; 'robust' works on slivers, non-manifold meshes and point clouds too.
            step: The share of the way towards the neighbours' mean that a vertex goes in one iteration, from 0 to 1; for
                'scale_dependent', 'laplace_beltrami' and 'robust' a diffusion time in squared mean edges, bounded by stability.
                Larger is smoother. Takes a number of at least 0.
            iterations: How many steps are taken. More are smoother and slower. Takes a whole number from 0 to 100000.
            update: 'euler' takes the step above. 'meshlab' repeats the rule of MeshLab's own Laplacian Smooth, where the vertex
                itself is averaged in and the step is not used; it knows the operators 'uniform' and 'cotangent'.
            border: What the vertices of open borders do: 'fixed' stay; 'along' are smoothed as a curve, seeing their neighbours
                on the border alone; 'free' move like any other vertex, so that borders recede.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [taubin1995], [fujiwara1995], [desbrun1999], [sharp2020]

        In scripts: 'Explicit Smoothing'.
        """

    def apply_coord_implicit_fairing(
        self,
        *,
        operator: Literal["uniform", "inverse_length", "scale_dependent", "cotangent", "robust"] = "cotangent",
        detail_size: LengthLike = "6edge",
        time_step: float = 0.0,
        iterations: int = 1,
        flow: Literal["linear", "mean_curvature", "conformalized"] = "linear",
        preserve_volume: bool = False,
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths strongly in one stable step, by solving (M - t C) p' = M p: the surface after a diffusion time t.

        The amount is given as the size of the details that are to vanish. Unlike explicit smoothing it does not depend on the
        sampling, and no step is too long.

        Args:
            operator: 'cotangent' is the Laplace-Beltrami operator: it does not depend on how the surface is triangulated;
                'robust' is the same for slivers, non-manifold meshes and point clouds; 'uniform', 'inverse_length' and
                'scale_dependent' see the triangulation and need a time step.
            detail_size: Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay.
                Larger is smoother. For the operators 'cotangent' and 'robust'; not used when a time step is given. Takes a
                length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            time_step: The diffusion time of one iteration, in squared mean edges (a pure number for 'uniform' and
                'inverse_length'). Larger is smoother; any value is stable. 0: not used, the detail size decides. Takes a number
                of at least 0.
            iterations: How many steps. At the same detail size more steps cut off more sharply; with a time step each one
                smooths further. Takes a whole number from 1 to 10000.
            flow: For several iterations: 'linear' keeps the operator of the input; 'mean_curvature' rebuilds it at each step;
                'conformalized' updates the areas alone, so that thin parts do not pinch off under strong smoothing.
            preserve_volume: Rescale every closed component about its centroid so that it keeps its volume. Open ones are left
                as they come out.
            border: What the vertices of open borders do: 'fixed' stay; 'along' are smoothed as a curve, seeing their neighbours
                on the border alone; 'free' move like any other vertex, so that borders recede.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [desbrun1999], [kazhdan2012], [sharp2020]

        In scripts: 'Implicit Fairing'.
        """

    def apply_coord_normal_filtering(
        self,
        *,
        method: Literal["auto", "mean", "unilateral", "bilateral", "averaged", "guided", "vertex_normals"] = "auto",
        range_kernel: Literal[
            "auto", "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "auto",
        space_kernel: Literal[
            "auto", "constant", "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "auto",
        range_measure: Literal["auto", "euclidean", "angle", "squared"] = "auto",
        range_sigma: float = 0.0,
        range_floor: float = -1.0,
        space_sigma: float = 0.0,
        neighborhood: Literal["auto", "edge", "vertex", "two_ring", "three_ring", "radius", "geodesic"] = "auto",
        normal_iterations: int = 0,
        vertex_iterations: int = 0,
        outer_iterations: int = 0,
        vertex_update: Literal["auto", "sun", "ohtake", "conjugate_gradient"] = "auto",
        relaxation: int = -1,
        relaxation_direction: Literal["auto", "all", "normal"] = "auto",
        choice: Literal["held_out", "fixed"] = "held_out",
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes noise and keeps edges: filters the normals of the faces robustly, then moves the vertices so that the faces
        follow.

        Without any parameter many settings are tried, and the one is taken that best predicts vertices which it has not seen;
        what is given replaces a part of that. Returns the parameters that were used, what the mesh was found to be, what was
        tried, the mean displacement of the vertices in mean edges ("drift"), and the number of faces that look away from those
        around them, before and after ("folded_before", "folded_after").

        Args:
            method: What the weight of a neighbouring face is made of, besides its area. 'mean': nothing else, which rounds
                every edge. 'unilateral': how far its normal deviates. 'bilateral': and how far away it is. 'averaged':
                bilateral, deviations measured on normals averaged before, for strong noise. 'guided': on the normals of the
                most even patches, for sharp edges. 'vertex_normals': bilateral on the normals of vertices, which loses edges;
                to compare with.
            range_kernel: How weight falls with the deviation of normals. 'truncated_l1', 'truncated_l2' and 'tukey' reach 0 and
                keep edges; 'huber', 'lorentzian' and 'gaussian' suit smooth shapes.
            space_kernel: How weight falls with distance; 'constant' does not.
            range_measure: How the deviation of two normals is measured: 'euclidean', the length of their difference, up to 2;
                'angle' in radians; 'squared', the square of that length.
            range_sigma: The deviation of normals at which the range kernel falls, in the unit of the range measure; 0.5 is
                about 30 degrees. Larger smooths more, and across sharper edges. 0: automatic. Takes a number of at least 0.
            range_floor: Smaller deviations count as this one. Above 0, such as 0.03, it keeps 'l1' and 'truncated_l1' from
                locking the normals of two faces that happen to agree. -1: automatic. Takes a number from -1 to 4.
            space_sigma: The distance at which the space kernel falls, in mean distances of neighbouring triangles' centres.
                Larger smooths larger details. 0: automatic. Takes a number of at least 0.
            neighborhood: Which faces are averaged over: those across the edges, those at the vertices, those in two or three
                rings, or those within a radius of twice the mean distance of centres, straight ('radius') or along the surface
                ('geodesic'), which does not jump across a thin wall. Larger smooths larger details and is slower.
            normal_iterations: How often the normals are filtered before the vertices follow. More smooth more. 0: automatic.
                Takes a whole number from 0 to 10000.
            vertex_iterations: How many steps the vertices take towards faces with the filtered normals. More follow them more
                closely. 0: automatic. Takes a whole number from 0 to 10000.
            outer_iterations: How often both are repeated, the normals measured anew; more are smoother. 20 to 30 times one
                normal iteration keep edges better than once 20. 0: automatic. Takes a whole number from 0 to 10000.
            vertex_update: How vertices follow: 'sun' by the mean of the projections onto their faces' planes, 'ohtake' by their
                mean weighted by area, 'conjugate_gradient' by descent on the sum of squared deviations.
            relaxation: How many pairs of Taubin's steps come before, of 0.5 and -0.53. They calm noise that turns faces over,
                and round edges, which the filter sharpens again. -1: automatic. Takes a whole number from -1 to 10000.
            relaxation_direction: Where these steps go: 'all' directions, which evens out noise along the surface too, or along
                the 'normal' alone, so that no vertex slides.
            choice: How what is not given is found. 'held_out': some 140 settings are tried on the mesh, or on patches of a
                large one, and the one is taken that best predicts vertices which it has not seen. 'fixed': all-round values, at
                once.
            border: What the vertices of open borders do: 'fixed' stay; 'along' move up and down along the normal alone, so that
                the outline stays; 'free' move like any other vertex.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [zheng2011], [zhang2015], [sun2007], [ohtake2001], [belyaev2001], [yadav2021]

        In scripts: 'Normal Filtering'.
        """

    def apply_coord_region_fairing(
        self,
        *,
        energy: Literal["membrane", "thin_plate", "minimum_variation"] = "thin_plate",
        iterations: int = 1,
    ) -> dict[str, Any] | None:
        """Replaces the selected part of a surface by the smoothest one that continues its surroundings.

        What the part looked like is forgotten: for dents, scars, bad fillings and seams. The selected vertices move, or, when
        no vertex is selected, those all of whose triangles are; the others, and open borders, stay. One, two or three rings of
        vertices around the region decide, so select until the damage ends, and a ring more. Returns how many vertices moved,
        the backward error of the solution, and a bound of the error that solving leaves as a share of the region's diagonal.

        Args:
            energy: 'membrane' spans it like a soap film, and meets its surroundings with a crease; 'thin_plate' bends least and
                continues their tangent planes; 'minimum_variation' continues their curvatures too, so that what is round stays
                round.
            iterations: How often, each time with the areas and angles that the one before has left. More forget the shape that
                was there more fully, and come nearer to the surface of least area or bending; one is mostly enough. Takes a
                whole number from 1 to 100.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [botsch2004]

        In scripts: 'Region Fairing'.
        """

    def apply_coord_spectral_filter(
        self,
        *,
        response: Literal["low_pass", "band_pass", "enhance"] = "low_pass",
        detail_size: LengthLike = "6edge",
        largest_size: LengthLike = "0",
        modes: int = 0,
        gain: float = 2.0,
        order: int = 2,
        method: Literal["auto", "eigenvectors", "polynomial"] = "auto",
        operator: Literal["auto", "cotangent", "robust"] = "auto",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes, keeps or exaggerates details by their size, as an equaliser does with sound.

        A surface is a sum of waves, the modes of its Laplace-Beltrami operator, from its largest parts to the finest noise. The
        filter multiplies each by a factor that depends on its wavelength alone, whatever the sampling. Components are filtered
        one by one, and their centroids stay. Open borders are natural: their vertices are free, and they get as smooth as the
        surface. Returns the route that was taken, the number of modes or the degree of the polynomial, the wavelength at the
        cutoff, and a bound of the error in mesh units.

        Args:
            response: 'low_pass' removes waves shorter than the detail size; 'enhance' multiplies those from the detail size to
                the largest size by the gain and keeps all others; 'band_pass' keeps that band alone, about the centroid of each
                component, to look at.
            detail_size: Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay. With
                'enhance' and 'band_pass' the shortest wave of the band: choose it above the size of the noise. Larger is
                smoother. Not used when a number of modes is given. Takes a length such as '1%' (of the bounding box's
                diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            largest_size: The longest wave of the band of 'enhance' and 'band_pass'. Larger takes in larger parts. 0: four
                detail sizes. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of
                at least 0.0.
            modes: In place of the detail size, how many modes (manifold harmonics) are kept, over all components; centroids
                stay and do not count. More keep finer features: 5 leave a blob, 500 most of them. 0: not used, the detail size
                decides. Takes a whole number from 0 to 1000000.
            gain: By what 'enhance' multiplies the waves of the band. Larger makes these details stronger, below 1 weaker. Takes
                a number from 0 to 10.
            order: How sharply the response falls at the detail size. 1 is diffusion; larger is sharper, slower, and leaves
                ripples beside edges. Not used with a number of modes, where eigenvectors cut off at once. Takes a whole number
                from 1 to 8.
            method: 'eigenvectors' computes the modes; 'polynomial' filters without them, far faster on large meshes; 'auto'
                computes modes only where their number is given and memory allows. The result says which ran.
            operator: 'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same for slivers and
                non-manifold meshes; 'auto' takes the robust one where it is needed.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [taubin1995], [vallet2008]

        In scripts: 'Spectral Filter'.
        """

    def apply_coord_tangential_smoothing(
        self,
        *,
        weight: float = 0.1,
        iterations: int = 5,
        max_deviation: LengthLike = "0.05edge",
        flip_edges: bool = False,
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Makes triangles better shaped on the same surface: vertices move along it towards the middle of their neighbours.

        Open borders stay. No triangle folds over. Colours and texture coordinates move along with their vertices. Triangles
        whose edges are flipped come last; they take colour and scalar from the old ones near them, and their custom attributes
        are 0. Returns the mean quality of the triangles before and after, as Surface Measures has it (1 for equilateral ones, 0
        for those without area), how many triangles flips have changed, how many vertices moved and how far the furthest went.

        Args:
            weight: How strongly vertices are held to their places. Larger moves them less in each iteration. Takes a number
                from 1e-09 to 1000000000.0.
            iterations: How many steps are taken. More give better triangles, up to a point, and take longer. Takes a whole
                number from 0 to 1000.
            max_deviation: How far the middles of triangles and edges may get from the surface as it was; vertices stay on it.
                Larger allows better triangles where the surface is curved or has edges. Takes a length such as '1%' (of the
                bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            flip_edges: Before each step, take the other diagonal of two neighbouring triangles where that makes them better:
                for range maps and other grids, where moving vertices alone does next to nothing. Not on textured meshes.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [nealen2006], [lawson1977], [botsch2004remeshing]

        In scripts: 'Tangential Smoothing'.
        """

    def apply_coord_taubin_fairing(
        self,
        *,
        operator: Literal["uniform", "inverse_length", "cotangent"] = "uniform",
        step: float = 0.5,
        mu: float = -0.53,
        pass_band: float = 0.0,
        iterations: int = 10,
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths without shrinking: each iteration is a smoothing step followed by a slightly longer step back.

        With the uniform operator it is MeshLab's own Taubin Smooth, except on open borders, where a step of MeshLab's goes two
        thirds of the way of ours.

        Args:
            operator: How neighbours are weighted. 'uniform' is Taubin's choice; 'inverse_length' keeps uneven sampling;
                'cotangent' moves vertices along the normal alone.
            step: The step that smooths, above 0. Larger is smoother per iteration. Takes a number from 0 to 1.
            mu: The step that inflates again, below minus the first one. Nearer to -lambda narrows the pass band and is
                smoother; not used when a pass band is given. Takes a number from -1.5 to 0.
            pass_band: Frequencies below it are kept, above it damped; on the operator's scale from 0 to 2, typically 0.01 to
                0.1. Smaller is smoother. 0: not used, mu decides. With it, mu = 1 / (pass band - 1 / lambda). Takes a number
                from 0 to 2.
            iterations: How many steps are taken. More are smoother and slower. Takes a whole number from 0 to 100000.
            border: What the vertices of open borders do: 'fixed' stay; 'along' are smoothed as a curve, seeing their neighbours
                on the border alone; 'free' move like any other vertex, so that borders recede.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [taubin1995]

        In scripts: 'Taubin Fairing'.
        """

    def apply_normal_robust_filtering_per_face(
        self,
        *,
        method: Literal["auto", "mean", "unilateral", "bilateral", "averaged", "guided", "vertex_normals"] = "auto",
        range_kernel: Literal[
            "auto", "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "auto",
        space_kernel: Literal[
            "auto", "constant", "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "auto",
        range_measure: Literal["auto", "euclidean", "angle", "squared"] = "auto",
        range_sigma: float = 0.0,
        range_floor: float = -1.0,
        space_sigma: float = 0.0,
        neighborhood: Literal["auto", "edge", "vertex", "two_ring", "three_ring", "radius", "geodesic"] = "auto",
        normal_iterations: int = 0,
        choice: Literal["held_out", "fixed"] = "held_out",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Averages the normals of the faces without rounding edges, and leaves the vertices where they are.

        It is the first half of Normal Filtering, for shading and for filters that read face normals. Without any parameter they
        are chosen from the noise that is measured; 0 normal iterations are as many as Normal Filtering takes in all. Returns
        the parameters that were used.

        Args:
            method: What the weight of a neighbouring face is made of, besides its area. 'mean': nothing else, which rounds
                every edge. 'unilateral': how far its normal deviates. 'bilateral': and how far away it is. 'averaged':
                bilateral, deviations measured on normals averaged before, for strong noise. 'guided': on the normals of the
                most even patches, for sharp edges. 'vertex_normals': bilateral on the normals of vertices, which loses edges;
                to compare with.
            range_kernel: How weight falls with the deviation of normals. 'truncated_l1', 'truncated_l2' and 'tukey' reach 0 and
                keep edges; 'huber', 'lorentzian' and 'gaussian' suit smooth shapes.
            space_kernel: How weight falls with distance; 'constant' does not.
            range_measure: How the deviation of two normals is measured: 'euclidean', the length of their difference, up to 2;
                'angle' in radians; 'squared', the square of that length.
            range_sigma: The deviation of normals at which the range kernel falls, in the unit of the range measure; 0.5 is
                about 30 degrees. Larger smooths more, and across sharper edges. 0: automatic. Takes a number of at least 0.
            range_floor: Smaller deviations count as this one. Above 0, such as 0.03, it keeps 'l1' and 'truncated_l1' from
                locking the normals of two faces that happen to agree. -1: automatic. Takes a number from -1 to 4.
            space_sigma: The distance at which the space kernel falls, in mean distances of neighbouring triangles' centres.
                Larger smooths larger details. 0: automatic. Takes a number of at least 0.
            neighborhood: Which faces are averaged over: those across the edges, those at the vertices, those in two or three
                rings, or those within a radius of twice the mean distance of centres, straight ('radius') or along the surface
                ('geodesic'), which does not jump across a thin wall. Larger smooths larger details and is slower.
            normal_iterations: How often the normals are filtered before the vertices follow. More smooth more. 0: automatic.
                Takes a whole number from 0 to 10000.
            choice: How what is not given is found. 'held_out': some 140 settings are tried on the mesh, or on patches of a
                large one, and the one is taken that best predicts vertices which it has not seen. 'fixed': all-round values, at
                once.
            selected: Only the selected faces get a new normal; the others are seen by their neighbours but keep theirs.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [zheng2011], [zhang2015], [belyaev2001], [yadav2021]

        In scripts: 'Robust Filtering of Face Normals'.
        """

    def apply_scalar_anisotropic_diffusion_per_vertex(
        self,
        *,
        range_kernel: Literal["lorentzian", "gaussian", "tukey", "huber", "hampel", "truncated_l2", "l2"] = "lorentzian",
        range_sigma: float = 0.0,
        step: float = 1.0,
        iterations: int = 10,
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths the vertex scalar over the mesh and keeps its edges, as Perona and Malik did for images. Vertices do not move.

        Args:
            range_kernel: How the flow between neighbours falls with their difference. 'lorentzian' and 'gaussian' are the
                paper's, 1 / (1 + x^2) and exp(-x^2); 'tukey', 'hampel' and 'truncated_l2' stop it at edges; 'huber' slows it,
                'l2' does not.
            range_sigma: Differences between neighbours above it are edges, and stay. Larger smooths stronger noise and blurs
                more edges. 0: from the median difference. Takes a number of at least 0.
            step: The share of the largest stable step, which is one over the largest number of neighbours of a vertex. Larger
                is smoother per iteration. Takes a number from 0 to 1.
            iterations: How many steps are taken. More are smoother and slower. Takes a whole number from 0 to 100000.
            selected: Only the selected vertices change; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [perona1990], [black1998]

        In scripts: 'Anisotropic Diffusion of Vertex Scalars'.
        """

    def compute_color_by_reflection_lines_per_vertex(
        self,
        *,
        stripes: float = 8.0,
        direction: Sequence[float] = (0.0, 1.0, 0.0),
        view: Sequence[float] = (0.0, 0.0, 1.0),
    ) -> dict[str, Any] | None:
        """Colours the vertices as if the mesh were polished and stood in a hall of parallel lamps.

        The lines jump where the surface has a crease and bend where its curvature does, which shading does not show. The
        brightness, from 0 to 1, becomes the vertex scalar. The colours are those for this one direction of view.

        Args:
            stripes: How many lamps there are all round. More show smaller defects; too many for the mesh flicker from vertex to
                vertex. Takes a number from 1 to 200.
            direction: Along the lamps, which are parallel and infinitely far. Takes three finite numbers.
            view: From the mesh to the eye. Takes three finite numbers.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Reflection Lines'.
        """

    def compute_scalar_by_displacement_per_vertex(
        self,
        *,
        reference: int = 0,
        correspondence: Literal["auto", "vertex", "surface"] = "auto",
        signed: bool = True,
        color: bool = True,
    ) -> dict[str, Any] | None:
        """Gives every vertex how far it lies from another layer: what a clean-up has moved.

        In mesh units. Signed: positive on the side to which the reference's faces look; blue below 0, nearly white there,
        orange above. Otherwise from dark violet to yellow. The limits enclose 98 % of the vertices. Returns the limits, the
        mean distance, the root of the mean square, the distance that 95 % keep below, the largest one, and whether vertices
        were compared by number.

        Args:
            reference: The layer from which the displacement is measured, such as the mesh before cleaning. Takes the id of a
                layer (a whole number).
            correspondence: 'vertex' measures from the vertex of the same number, 'surface' from the nearest place of the
                reference; 'auto' takes 'vertex' where the two layers have the same faces.
            signed: Negative where the mesh lies on the inner side of the reference. Without it all values are distances.
            color: Colour the mesh by the scalar, too, which replaces its colours. Without it only the scalar is written.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Displacement from Another Layer'.
        """

    def compute_scalar_by_gaussian_curvature_per_vertex(
        self,
        *,
        measure: Literal["per_area", "deficit"] = "per_area",
        color: bool = True,
    ) -> dict[str, Any] | None:
        """Gives every vertex its Gaussian curvature: 1/r^2 on a sphere of radius r, 0 on cylinders and planes, negative on
        saddles.

        Colours: blue on saddles, nearly white where the surface can be unrolled, orange on domes and in bowls, between limits
        that enclose 98 % of the vertices. Per area it is 0 on borders; as a deficit it is there how far the border turns.
        Returns the limits, the lowest, the highest and the mean value, and the sum.

        Args:
            measure: 'per_area' is the curvature, in 1 / squared mesh unit; 'deficit' is the angle that is missing there, in
                radians, which adds up to 2 pi times the Euler characteristic.
            color: Colour the mesh by the scalar, too, which replaces its colours. Without it only the scalar is written.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [meyer2003]

        In scripts: 'Gaussian Curvature by Angle Deficit'.
        """

    def compute_scalar_by_manifold_harmonic_per_vertex(
        self,
        *,
        mode: int = 10,
        operator: Literal["auto", "cotangent", "robust"] = "auto",
    ) -> dict[str, Any] | None:
        """Makes a mode of the surface, one of the waves that spectral filters keep or remove, the vertex scalar to look at.

        Modes are for a surface what sines are for sound: eigenfunctions of the Laplace-Beltrami operator. Its mean square over
        the surface is 1, its sign is arbitrary but always the same; it is 0 at vertices without a triangle and on other
        components. Returns its frequency (radians per mesh unit), its wavelength (2 pi / frequency) and its eigenvalue (the
        frequency squared).

        Args:
            mode: Which one, by rising frequency over all components. 0 is constant, 1 the longest wave, whatever the number of
                components; larger has shorter waves and takes longer. Takes a whole number from 0 to 1000000.
            operator: 'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same for slivers and
                non-manifold meshes; 'auto' takes the robust one where it is needed.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [vallet2008]

        In scripts: 'Manifold Harmonic'.
        """

    def compute_scalar_by_mean_curvature_per_vertex(
        self,
        *,
        operator: Literal["cotangent", "uniform"] = "cotangent",
        color: bool = True,
    ) -> dict[str, Any] | None:
        """Gives every vertex its mean curvature: 1/r on a sphere of radius r, positive on bulges and negative in hollows.

        In 1 / mesh unit; 0 on borders. Colours: blue in hollows, nearly white where it is flat, orange on bulges, between
        limits that enclose 98 % of the vertices. The sign follows the orientation of the faces. Returns the limits, the lowest,
        the highest and the mean value.

        Args:
            operator: 'cotangent' is the Laplace-Beltrami operator, right on every mesh; 'uniform' is the mean of the
                neighbours, calm at slivers, but wrong where vertices are spread unevenly.
            color: Colour the mesh by the scalar, too, which replaces its colours. Without it only the scalar is written.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [meyer2003]

        In scripts: 'Mean Curvature by Laplacian'.
        """

    def compute_scalar_by_triangle_shape_per_face(
        self,
        *,
        color: bool = True,
    ) -> dict[str, Any] | None:
        """Gives every face its shape: 1 for an equilateral triangle, towards 0 for slivers, 0 without area.

        The shortest edge over the radius of the circumcircle, normalised. Colours from dark violet at 0 to bright yellow at 1.
        Returns the limits, the lowest, the highest and the mean value.

        Args:
            color: Colour the mesh by the scalar, too, which replaces its colours. Without it only the scalar is written.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Triangle Shape'.
        """

    def compute_selection_by_outlier_probability_per_vertex(
        self,
        *,
        neighbors: int = 20,
        extent: float = 3.0,
        threshold: float = 0.5,
    ) -> dict[str, Any] | None:
        """Selects the vertices that are probably outliers, and gives every vertex that probability.

        LoOP (local outlier probability) compares how far each vertex is from its neighbours with how far they are from theirs:
        dense and sparse parts of a scan are judged alike, whatever its unit. The probability, from 0 to 1, becomes the vertex
        scalar, to be looked at in colours before anything is deleted. The selection of vertices is replaced, that of faces
        stays. Faces play no part: a point cloud and a mesh with the same vertices have the same outliers. Returns the number of
        selected vertices, the largest and the mean probability.

        Args:
            neighbors: How many nearest points a point is compared with. It must exceed the size of the clumps of stray points
                that are to be found. More give steadier probabilities, blur borders between dense and sparse parts, and take
                longer. Takes a whole number of at least 1.
            extent: How far beyond the usual a point must be to count as an outlier for certain, in standard deviations: 2 takes
                95 % of the points for regular, 3 takes 99.7 %. Larger gives lower probabilities, so fewer points are selected.
                Takes a number of at least 0.1.
            threshold: Vertices with a probability above it are selected. Larger selects fewer: 1 none, 0 every vertex that is
                at all farther from its neighbours than they are from theirs. Takes a number from 0 to 1.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [kriegel2009]

        In scripts: 'Select Outliers by Probability (LoOP)'.
        """

    def get_surface_measures(self) -> dict[str, Any] | None:
        """Counts, topology, size, roughness and triangle quality of the mesh.

        Counts vertices, faces, edges, border edges, non-manifold edges and vertices, degenerate faces and components; says
        whether the surface is closed and oriented, its genus and Euler characteristic; measures area, volume (of closed
        surfaces), the mean edge (of polylines, too), roughness (the mean angle in degrees between faces that share an edge) and
        the mean triangle quality (1 for equilateral ones); of a point cloud the mean distance to the nearest point. Changes
        nothing. Exact far from the origin, too.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Surface Measures'.
        """

    def get_surface_spectrum(
        self,
        *,
        modes: int = 50,
        operator: Literal["auto", "cotangent", "robust"] = "auto",
    ) -> dict[str, Any] | None:
        """How much of the shape lies at which frequency: where it ends and where noise begins.

        The energy of a frequency is what its waves add to the mean squared distance of the surface from the centroids of its
        components, in squared mesh units; a frequency is 2 pi over a wavelength, in radians per mesh unit. Returns the
        frequencies and energies of the lowest modes, and the energies of bands of a third of an octave up to the finest waves
        of the mesh.

        Args:
            modes: How many modes are listed, from the lowest. More reach higher frequencies and take longer; the energies of
                bands do not need them. Takes a whole number from 0 to 100000.
            operator: 'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same for slivers and
                non-manifold meshes; 'auto' takes the robust one where it is needed.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [vallet2008], [golub1969]

        In scripts: 'Surface Spectrum'.
        """

    def meshing_bridge_rims_by_fairing(
        self,
        *,
        energy: Literal["membrane", "thin_plate", "minimum_variation"] = "thin_plate",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Joins two parts of a mesh by a smooth neck between the two rims that face each other.

        A rim is a loop of border edges. The two rims nearest each other get a band of triangles between them, as dense as they
        are, whose inside is then faired; the parts themselves stay as they are. The new vertices and triangles are selected.
        Parts in several layers are merged into one first (Flatten Visible Layers). Returns how many vertices and triangles are
        new, and how many edges each rim has.

        Args:
            energy: 'membrane' spans it like a soap film, and meets its surroundings with a crease; 'thin_plate' bends least and
                continues their tangent planes; 'minimum_variation' continues their curvatures too, so that what is round stays
                round.
            selected: Join the two selected rims that lie nearest each other, which may belong to one part; a rim is selected
                when all of its vertices are. Otherwise the two nearest rims of different parts are joined.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [fuchs1977], [botsch2004]

        In scripts: 'Bridge Rims by Fairing'.
        """

    def meshing_close_holes_by_fairing(
        self,
        *,
        max_edges: int = 300,
        energy: Literal["none", "membrane", "thin_plate", "minimum_variation"] = "thin_plate",
        refine: bool = True,
        rounds: int = 3,
        islands: Literal["join", "leave"] = "join",
        selected: bool = False,
        mark: Literal["none", "scalar", "color"] = "none",
    ) -> dict[str, Any] | None:
        """Closes holes with triangles as dense as those around, which continue the surface smoothly across the rim.

        What is there stays as it is, textures too. New vertices and faces come last and are the ones that are selected
        afterwards, so that a next step can delete, smooth or measure them. They take colours, scalars and texture from the rim.
        A mark is written if a hole was closed: "scalar" overwrites the scalars of all faces, "color" the colours of the new
        ones. Returns how many holes were closed and the edges of each rim, how many vertices and faces are new, how many holes
        were filled by a lower energy, and how many rims were left open, why and with how many edges; the largest are named one
        by one.

        Args:
            max_edges: The most edges that the rim of a hole may have. Larger closes larger holes; one of 10,000 edges takes
                half a gigabyte of memory and more. Outer borders of open sheets stay open, whatever their size: rims that turn
                like that of a flat disc, and those that span more than a third of the area of their sheet, unless they are
                selected. Takes a whole number from 3 to 10000.
            energy: How the new vertices are placed: 'membrane' spans a hole like a soap film, with a crease at its rim;
                'thin_plate' continues the tangent planes around; 'minimum_variation' continues the curvatures too, so that what
                is round stays round, and follows noise at the rim; 'none' leaves them flat as they were made. A hole at whose
                rim there are degenerate triangles may get a lower energy than the others, which is said.
            refine: Split the new faces until they are as dense as those around. Without, a hole is closed by faces between the
                vertices of its rim alone, and nothing is faired.
            rounds: How often the new faces are refined and faired. More let a filling bulge further where its rim suggests
                that. Takes a whole number from 1 to 100.
            islands: Pieces of surface that lie loose in a hole: 'join' makes them part of the filling, or leaves the hole open
                if that cannot be done; 'leave' fills the hole without regard to them.
            selected: Close only holes whose rim has a selected vertex, or a vertex of a selected face, those too that otherwise
                count as outer borders by their area.
            mark: How new faces are marked in a saved file: 'scalar' gives each the number of the hole that it closes, from 1,
                and all others 0, in place of the scalars that faces had; 'color' paints them orange, and the others white if
                faces had no colours; 'none' leaves both as they are.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [liepa2003]

        In scripts: 'Close Holes by Fairing'.
        """
