# Written by `python -m pymeshfair.stubs` from the declarations of the filters; change those instead.
"""`MeshSet`: pymeshlab's mesh set with the filters of plugins as methods beside MeshLab's own."""

from typing import Any, Literal

from .applying.methods import LengthLike
from .applying.script import ScriptedMeshSet

class MeshSet(ScriptedMeshSet):
    """A set of meshes that filters are applied to, a drop-in for `pymeshlab.MeshSet`."""

    @staticmethod
    def filter_list() -> list[str]: ...
    def __getattr__(self, name: str) -> Any: ...
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
            selected: Only the selected vertices move; the others are seen by their neighbours but stay. When no vertex is
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
            selected: Only the selected vertices move; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [desbrun1999], [kazhdan2012], [sharp2020]

        In scripts: 'Implicit Fairing'.
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
            mu: The step that inflates again, below minus the first one. Nearer to -lambda keeps more detail; not used when a
                pass band is given. Takes a number from -1.5 to 0.
            pass_band: Frequencies below it are kept, above it damped; on the operator's scale from 0 to 2, typically 0.01 to
                0.1. Smaller is smoother. 0: not used, mu decides. With it, mu = 1 / (pass band - 1 / lambda). Takes a number
                from 0 to 2.
            iterations: How many steps are taken. More are smoother and slower. Takes a whole number from 0 to 100000.
            border: What the vertices of open borders do: 'fixed' stay; 'along' are smoothed as a curve, seeing their neighbours
                on the border alone; 'free' move like any other vertex, so that borders recede.
            selected: Only the selected vertices move; the others are seen by their neighbours but stay. When no vertex is
                selected, the vertices all of whose triangles are selected.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [taubin1995]

        In scripts: 'Taubin Fairing'.
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

        Counts vertices, faces, edges, border edges, non-manifold edges and vertices, degenerate faces and components; tells
        whether the surface is closed and oriented, its genus and Euler characteristic; measures area, volume (of closed
        surfaces), the mean edge, roughness (the mean angle in degrees between faces that share an edge) and the mean triangle
        quality (1 for equilateral ones); of a point cloud the mean distance to the nearest point. Changes nothing. Exact far
        from the origin, too.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Surface Measures'.
        """
