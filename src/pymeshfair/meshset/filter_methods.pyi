# Written by `python tools/generate.py stubs` from the declarations of the filters; change those instead.
"""The filters as methods, for `MeshSet` to inherit."""

from typing import Any, Literal

from .methods import ColorLike, LengthLike, MatrixLike, PointLike

class LateMethods(type): ...

class FilterMethods(metaclass=LateMethods):
    """One method for each filter, MeshLab's and pymeshfair's; those of other plugins are given to `apply_filter`."""

    def apply_cameras_extrinsics_transformation(
        self,
        *,
        transformmatrix: MatrixLike = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
        camera: Literal["Raster Camera", "Mesh Camera"] = "Raster Camera",
        behaviour: Literal[
            "The matrix is the transformation to apply to the extrinsics", "The matrix represent the new extrinsics"
        ] = "The matrix is the transformation to apply to the extrinsics",
        toallraster: bool = False,
        toall: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform the camera extrinsics, or all the cameras of the project'.

        Menus: raster layer, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_cameras_extrinsics_transformation

        Args:
            transformmatrix: 'TransformMatrix' in scripts. Takes a 4 x 4 matrix of finite numbers.
            camera: 'camera' in scripts.
            behaviour: 'behaviour' in scripts.
            toallraster: 'toallRaster' in scripts.
            toall: 'toall' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_cameras_rotation(
        self,
        *,
        camera: Literal["Raster Camera", "Mesh Camera"] = "Raster Camera",
        rotaxis: Literal["X axis", "Y axis", "Z axis", "custom axis"] = "X axis",
        rotcenter: Literal["origin", "camera viewpoint", "custom point"] = "origin",
        angle: float = 0.0,
        customaxis: PointLike = (0.0, 0.0, 0.0),
        customcenter: PointLike = (0.0, 0.0, 0.0),
        toallraster: bool = False,
        toall: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform: Rotate Camera or set of cameras'.

        Menus: raster layer, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_cameras_rotation

        Args:
            camera: 'camera' in scripts.
            rotaxis: 'rotAxis' in scripts.
            rotcenter: 'rotCenter' in scripts.
            angle: 'angle' in scripts. Takes a number from -360.0 to 360.0.
            customaxis: 'customAxis' in scripts. Takes three finite numbers.
            customcenter: 'customCenter' in scripts. Takes three finite numbers.
            toallraster: 'toallRaster' in scripts.
            toall: 'toall' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_cameras_scaling(
        self,
        *,
        camera: Literal["Raster Camera", "Mesh Camera"] = "Raster Camera",
        scalecenter: Literal["origin", "camera viewpoint", "custom point"] = "origin",
        customcenter: PointLike = (0.0, 0.0, 0.0),
        scale: float = 1.0,
        toallraster: bool = False,
        toall: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform: Scale Camera or set of cameras'.

        Menus: raster layer, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_cameras_scaling

        Args:
            camera: 'camera' in scripts.
            scalecenter: 'scaleCenter' in scripts.
            customcenter: 'customCenter' in scripts. Takes three finite numbers.
            scale: 'scale' in scripts. Takes a number.
            toallraster: 'toallRaster' in scripts.
            toall: 'toall' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_cameras_translation(
        self,
        *,
        camera: Literal["Raster Camera", "Mesh Camera"] = "Raster Camera",
        axisx: float = 0.0,
        axisy: float = 0.0,
        axisz: float = 0.0,
        centerflag: bool = False,
        toallraster: bool = False,
        toall: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform: Translate Camera or set of cameras'.

        Menus: raster layer, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_cameras_translation

        Args:
            camera: 'camera' in scripts.
            axisx: 'axisX' in scripts. Takes a number from -1000.0 to 1000.0.
            axisy: 'axisY' in scripts. Takes a number from -1000.0 to 1000.0.
            axisz: 'axisZ' in scripts. Takes a number from -1000.0 to 1000.0.
            centerflag: 'centerFlag' in scripts.
            toallraster: 'toallRaster' in scripts.
            toall: 'toall' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_anisotropic_diffusion_per_vertex(
        self,
        *,
        range_kernel: Literal["lorentzian", "gaussian", "tukey", "huber", "hampel", "truncated_l2", "l2"] = "lorentzian",
        range_sigma: float | Literal["auto"] = "auto",
        step: float = 1.0,
        iterations: int = 10,
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths the vertex colours over the mesh and keeps their edges (jumps): red, green and blue alike. Opacity stays.

        Args:
            range_kernel: How the flow between neighbours falls with x, their difference divided by range sigma. 'lorentzian', 1
                / (1 + x^2), and 'gaussian', exp(-x^2), are the kernels of Perona and Malik; 'tukey' and 'truncated_l2' stop the
                flow at x = 1, 'hampel' at 4; 'huber' slows it; 'l2' smooths across edges.
            range_sigma: Differences between neighbouring colours above this value are edges, and are kept; black and white
                differ by 1.73. Larger smooths stronger noise and blurs more edges. 'auto' estimates it from the median
                difference. Takes a number of at least 0, or 'auto'.
            step: The step as a share of the largest stable step, which is one over the largest number of neighbours of a
                vertex. Larger is smoother per iteration. Takes a number from 0 to 1.
            iterations: The number of steps. More steps smooth more. Takes a whole number from 0 to 100000.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [perona1990], [black1998]

        In scripts: 'Anisotropic Diffusion of Vertex Colors'.
        """

    def apply_color_brightness_contrast_gamma_per_vertex(
        self,
        *,
        brightness: float = 0.0,
        contrast: float = 0.0,
        gamma: float = 1.0,
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Color Brightness Contrast Gamma'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_brightness_contrast_gamma_per_vertex

        Args:
            brightness: 'brightness' in scripts. Takes a number from -255.0 to 255.0.
            contrast: 'contrast' in scripts. Takes a number from -255.0 to 255.0.
            gamma: 'gamma' in scripts. Takes a number from 0.1 to 5.0.
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_desaturation_per_vertex(
        self,
        *,
        method: Literal["Lightness", "Luminosity", "Average"] = "Lightness",
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Color Desaturation'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_desaturation_per_vertex

        Args:
            method: 'method' in scripts.
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_equalization_per_vertex(
        self,
        *,
        rch: bool = True,
        gch: bool = True,
        bch: bool = True,
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Equalize Vertex Color'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_equalization_per_vertex

        Args:
            rch: 'rCh' in scripts.
            gch: 'gCh' in scripts.
            bch: 'bCh' in scripts.
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_intensity_colourisation_per_vertex(
        self,
        *,
        hue: float = 0.0,
        saturation: float = 100.0,
        luminance: float = 50.0,
        intensity: float = 50.0,
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Color Colourisation'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_intensity_colourisation_per_vertex

        Args:
            hue: 'hue' in scripts. Takes a number from 0.0 to 360.0.
            saturation: 'saturation' in scripts. Takes a number from 0.0 to 100.0.
            luminance: 'luminance' in scripts. Takes a number from 0.0 to 100.0.
            intensity: 'intensity' in scripts. Takes a number from 0.0 to 100.0.
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_inverse_per_vertex(
        self,
        *,
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Color Invert'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_inverse_per_vertex

        Args:
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_laplacian_smoothing_per_face(
        self,
        *,
        iteration: int = 1,
    ) -> Any:
        """MeshLab's filter 'Smooth: Laplacian Face Color'.

        Menus: face coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_laplacian_smoothing_per_face

        Args:
            iteration: 'iteration' in scripts. Takes a whole number from 0 to 100000.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_laplacian_smoothing_per_vertex(
        self,
        *,
        iteration: int = 1,
    ) -> Any:
        """MeshLab's filter 'Smooth: Laplacian Vertex Color'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_laplacian_smoothing_per_vertex

        Args:
            iteration: 'iteration' in scripts. Takes a whole number from 0 to 100000.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_level_adjustment_per_vertex(
        self,
        *,
        gamma: float = 1.0,
        in_min: float = 0.0,
        in_max: float = 255.0,
        out_min: float = 0.0,
        out_max: float = 255.0,
        rch: bool = True,
        gch: bool = True,
        bch: bool = True,
        onselected: bool = False,
        apply_to_all: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Color Levels Adjustment'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_level_adjustment_per_vertex

        Args:
            gamma: 'gamma' in scripts. Takes a number from 0.1 to 5.0.
            in_min: 'in_min' in scripts. Takes a number from 0.0 to 255.0.
            in_max: 'in_max' in scripts. Takes a number from 0.0 to 255.0.
            out_min: 'out_min' in scripts. Takes a number from 0.0 to 255.0.
            out_max: 'out_max' in scripts. Takes a number from 0.0 to 255.0.
            rch: 'rCh' in scripts.
            gch: 'gCh' in scripts.
            bch: 'bCh' in scripts.
            onselected: 'onSelected' in scripts.
            apply_to_all: 'apply_to_all' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_noising_per_vertex(
        self,
        *,
        noisebits: int = 1,
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Color noise'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_noising_per_vertex

        Args:
            noisebits: 'noiseBits' in scripts. Takes a whole number of at least 0.
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_thresholding_per_vertex(
        self,
        *,
        color1: ColorLike = (0, 0, 0, 255),
        color2: ColorLike = (255, 255, 255, 255),
        threshold: float = 128.0,
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Color Thresholding'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_thresholding_per_vertex

        Args:
            color1: 'color1' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue, opacity).
            color2: 'color2' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue, opacity).
            threshold: 'threshold' in scripts. Takes a number from 0.0 to 255.0.
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_unsharp_mask_per_vertex(
        self,
        *,
        weight: float = 0.3,
        weightorig: float = 1.0,
        iterations: int = 5,
    ) -> Any:
        """MeshLab's filter 'UnSharp Mask Color'.

        Menus: vertex coloring, smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_unsharp_mask_per_vertex

        Args:
            weight: 'weight' in scripts. Takes a number.
            weightorig: 'weightOrig' in scripts. Takes a number.
            iterations: 'iterations' in scripts. Takes a whole number from 0 to 100000.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_color_white_balance_per_vertex(
        self,
        *,
        color: ColorLike = (255, 255, 255, 255),
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Color White Balance'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_color_white_balance_per_vertex

        Args:
            color: 'color' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue, opacity).
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
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
        """Smooths by balancing the bending of the surface against the displacement of vertices: (C M^-1 W C + w M) p' = w M p.

        C is the stiffness and M the mass of the surface; W is 1, or nearly 0 at features, where the surface may bend. Shapes
        shrink far less than by implicit fairing at the same detail size. Returns w in 1 / (mesh unit)^4 (infinite without
        smoothing, 0 or infinite if w under- or overflows), the number of moved vertices and the largest displacement.

        Args:
            detail_size: Waves of this length keep half their amplitude: smaller details vanish, larger ones stay. Larger is
                smoother. 'auto' chooses the size for the noise of the mesh. Takes a length such as '1%' (of the bounding box's
                diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0, or 'auto'.
            weight: The weight w that holds vertices in place, in 1 / (mean edge)^4. Larger stays closer to the input: 0.02
                smooths strongly, 0.2 mildly. 0: not used, the detail size decides. Takes a number of at least 0.
            features: The features to keep. 'none'; 'curvature': ridges, where the surface bends by more than the feature angle,
                stay sharp; 'scalar': parts whose vertex scalar is far from 0.
            feature_angle: For 'curvature': the angle between adjacent triangles, in degrees, at which W is 1/2; noise is
                filtered out beforehand. Larger keeps only sharper ridges. Takes a number from 1 to 179.
            feature_scalar: For 'scalar': q0 in W = 1 / (1 + (q / q0)^2) at a scalar q. Larger keeps only parts farther from 0.
                Takes a number from 1e-30 to 1e+30.
            border: How vertices on open borders move. 'fixed': they stay. 'along': they are smoothed as a curve, with only
                their neighbours on the border. 'free': they move like any other vertex, so that borders recede.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

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
        range_sigma: LengthLike = "auto",
        space_sigma: LengthLike = "auto",
        iterations: int = 2,
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes noise and keeps features: every vertex moves along its normal to the mean height of neighbours at similar
        heights.

        Fast, and enough for light noise; triangles keep their shape. The surface shrinks a little with each iteration.

        Args:
            range_kernel: How weight falls with the difference in height of a neighbour. 'huber' and 'l1' keep features less,
                'l2' not at all; the others keep them.
            space_kernel: How weight falls with distance. 'gaussian' is the papers' kernel, 'l2' weights all neighbours equally,
                'l1' favours the nearest.
            range_sigma: Differences in height below this value count as noise, above it as features. A larger value removes
                stronger noise, and flattens larger features. 'auto' estimates the value from the mesh. Takes a length such as
                '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0, or 'auto'.
            space_sigma: Neighbours count up to 1.4 times this distance. Larger is smoother and slower. 'auto': 1.4 mean edges.
                Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0,
                or 'auto'.
            iterations: The number of steps. More steps smooth more, take longer, and shrink more. Takes a whole number from 0
                to 10000.
            border: How vertices on open borders move. 'fixed': they stay. 'along': they are smoothed as a curve, with only
                their neighbours on the border. 'free': they move like any other vertex, so that borders recede.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

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
        range_sigma: LengthLike = "auto",
        space_sigma: LengthLike = "auto",
        border: Literal["fixed", "free"] = "free",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes noise and keeps features in one step: every vertex moves to the mean of its projections onto triangle planes.

        A triangle counts more if it and its plane are near the vertex. Triangles are found by distance, so that non-manifold
        meshes and loose triangles are filtered too; curved surfaces shrink less than with the filter along normals.

        Args:
            range_kernel: How weight falls with the difference in height of a neighbour. 'huber' and 'l1' keep features less,
                'l2' not at all; the others keep them.
            space_kernel: How weight falls with distance. 'gaussian' is the papers' kernel, 'l2' weights all neighbours equally,
                'l1' favours the nearest.
            range_sigma: Differences in height below this value count as noise, above it as features. A larger value removes
                stronger noise, and flattens larger features. 'auto' estimates the value from the mesh. Takes a length such as
                '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0, or 'auto'.
            space_sigma: Triangles count up to 1.4 times this distance. Larger is smoother and slower. 'auto': 2 mean edges.
                Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0,
                or 'auto'.
            border: How vertices on open borders move: 'fixed' stay; 'free' move like any other vertex.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

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
        range_sigma: LengthLike = "auto",
        space_sigma: LengthLike = "auto",
        iterations: int | Literal["auto"] = 2,
        degree: int = 1,
        use_normals: bool = False,
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes noise from a point cloud: every point moves along its normal to a height fitted to neighbours at similar
        heights.

        Triangles are ignored. The normals do not change: compute them again afterwards. With automatic iterations a cloud
        without noise stays as it is, and the choice and the trials are returned; errors are in median distances of near points.

        Args:
            neighbors: The number of nearest points that count. More points smooth more, take longer, and round off edges. Takes
                a whole number of at least 3.
            range_kernel: How weight falls with the difference in height of a neighbour. 'huber' and 'l1' keep features less,
                'l2' not at all; the others keep them.
            space_kernel: How weight falls with distance. 'gaussian' is the papers' kernel, 'l2' weights all neighbours equally,
                'l1' favours the nearest.
            range_sigma: Differences in height below this value count as noise, above it as features. A larger value removes
                stronger noise, and flattens larger features. 'auto' estimates the value from the mesh. Takes a length such as
                '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0, or 'auto'.
            space_sigma: The distance at which the weight of neighbours falls. Larger makes distant neighbours count more.
                'auto' takes it from the mean distance of the farthest neighbour. Takes a length such as '1%' (of the bounding
                box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0, or 'auto'.
            iterations: The number of steps. More steps smooth more, take longer, and shrink more. 'auto' chooses the
                iterations, neighbours, degree and, if automatic, range sigma together, for a small prediction error at held-out
                points. Takes a whole number from 0 to 10000, or 'auto'.
            degree: 1 moves points to the mean height of their neighbours, 2 onto the quadric that fits these heights best. With
                quadrics curved surfaces shrink less, but quadrics need 40 or more neighbours. Takes a whole number from 1 to 2.
            use_normals: Move along the given normals of the points. Otherwise each iteration estimates the normals again.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [fleishman2003], [cazals2005]

        In scripts: 'Bilateral Projection of Points'.
        """

    def apply_coord_craters_from_point_cloud(
        self,
        *,
        target_mesh: int = ...,
        samples_mesh: int = ...,
        seed: int = 0,
        smoothingsteps: int = 5,
        rbf: Literal["f1 (Gaussian)", "f2 (Multiquadric)", "f3"] = "f2 (Multiquadric)",
        min_radius: float = 0.1,
        max_radius: float = 0.35,
        min_depth: float = 0.05,
        max_depth: float = 0.15,
        elevation: float = 0.4,
        blend: Literal["Exponential blending", "Linear blending", "Gaussian blending", "f3 blending"] = "f3 blending",
        blendthreshold: float = 0.8,
        successiveimpacts: bool = True,
        ppnoise: bool = True,
        invert: bool = False,
        save_as_quality: bool = False,
    ) -> Any:
        """MeshLab's filter 'Craters Generation'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_craters_from_point_cloud

        Args:
            target_mesh: 'target_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            samples_mesh: 'samples_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            seed: 'seed' in scripts. Takes a whole number.
            smoothingsteps: 'smoothingSteps' in scripts. Takes a whole number from 0 to 100000.
            rbf: 'rbf' in scripts.
            min_radius: 'min_radius' in scripts. Takes a number from 0.0 to 1.0.
            max_radius: 'max_radius' in scripts. Takes a number from 0.0 to 1.0.
            min_depth: 'min_depth' in scripts. Takes a number from 0.0 to 1.0.
            max_depth: 'max_depth' in scripts. Takes a number from 0.0 to 1.0.
            elevation: 'elevation' in scripts. Takes a number from 0.0 to 1.0.
            blend: 'blend' in scripts.
            blendthreshold: 'blendThreshold' in scripts. Takes a number from 0.0 to 1.0.
            successiveimpacts: 'successiveImpacts' in scripts.
            ppnoise: 'ppNoise' in scripts.
            invert: 'invert' in scripts.
            save_as_quality: 'save_as_quality' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_cubic_stylization(
        self,
        *,
        lcubeness: float = 0.2,
        applyef: bool = False,
        applycol: bool = False,
    ) -> Any:
        """MeshLab's filter 'Cubic stylization'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_cubic_stylization

        Args:
            lcubeness: 'lcubeness' in scripts. Takes a number.
            applyef: 'applyef' in scripts.
            applycol: 'applycol' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
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

        Planar curves stay in their plane. A vertex at a branch moves towards the mean of all its neighbours. Faces of the layer
        are ignored.

        Args:
            method: 'explicit': every vertex moves a step towards its neighbours; closed curves shrink. 'implicit': waves below
                the detail size vanish, any step length is stable, and closed curves shrink a little. 'taubin': a step and a
                longer step back, so that curves keep their size.
            weights: 'inverse_length': near neighbours pull more, so that uneven sampling is kept and straight parts do not
                move. 'uniform': all neighbours pull equally, which evens out the distances along the curve.
            detail_size: Waves of this length keep half their amplitude: smaller details vanish, larger ones stay. Larger is
                smoother. Only for 'implicit' with weights 'inverse_length'. Takes a length such as '1%' (of the bounding box's
                diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.
            time_step: For 'implicit': the strength of one iteration, a pure number; uniform weights need it. Larger is
                smoother; any value is stable. 0: not used, the detail size decides. Takes a number of at least 0.
            step: For 'explicit' and 'taubin': how far a vertex moves towards the mean of its neighbours, as a share above 0.
                Larger is smoother. Takes a number from 0 to 1.
            mu: The step back, which undoes the shrinking; it must be below -step. Nearer to -step smooths more; not used when a
                pass band is given. Only for Taubin's method. Takes a number from -1.5 to 0.
            pass_band: For 'taubin': frequencies below it are kept, above it damped; m waves round a closed curve of n vertices
                have the frequency 1 - cos(2 pi m / n). Smaller is smoother. 0: not used, mu decides. Takes a number from 0 to
                2.
            iterations: The number of steps ('taubin': of pairs). More smooth more; with a detail size they only sharpen the
                cutoff. Takes a whole number from 1 to 100000.
            border: How the ends of open curves move: 'fixed' ends stay; 'free' ends move towards their neighbours.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [taubin1995], [desbrun1999]

        In scripts: 'Curve Smoothing'.
        """

    def apply_coord_depth_smoothing(
        self,
        *,
        stepsmoothnum: int = 3,
        viewpoint: PointLike = (0.0, 0.0, 0.0),
        delta: LengthLike = "1",
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Depth Smooth'.

        Menus: smoothing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_depth_smoothing

        Args:
            stepsmoothnum: 'stepSmoothNum' in scripts. Takes a whole number from 0 to 100000.
            viewpoint: 'viewPoint' in scripts. Takes three finite numbers.
            delta: 'delta' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_detail_enhancement(
        self,
        *,
        gain: float = 2.0,
        detail_size: LengthLike = "auto",
        largest_size: LengthLike = "auto",
        most: float = 0.05,
        operator: Literal["auto", "cotangent", "robust"] = "auto",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Makes the relief of a surface, such as worn letters, higher, and keeps the shape, the size and the borders.

        Vertices move along the normals that the surface would have without relief; waves shorter or longer than those of the
        relief stay. Near open borders and in thin parts vertices move less; parts far thinner than the longest wave stay.
        Returns the shortest and the longest wavelength of the relief, its height in the input (root mean square), and the
        largest displacement.

        Args:
            gain: The factor for the height of the relief. Larger makes the relief higher, a gain below 1 flatter; 1 changes
                nothing. Takes a number from 0 to 10.
            detail_size: The shortest wave of the relief: choose it above the size of the noise. Larger includes only larger
                details. 'auto': about the shortest wavelength at which the spectrum clearly exceeds the noise, at least five
                mean edges. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at
                least 0.0, or 'auto'.
            largest_size: The longest wave of the relief. Larger includes larger parts. 'auto': four detail sizes. Takes a
                length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0, or
                'auto'.
            most: The largest displacement of a vertex, as a share of the thickness of the body there, or of the gap in front of
                the vertex if the gap is smaller. Larger lets thin parts change more. Takes a number from 0.001 to 0.5.
            operator: 'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same operator for slivers and
                non-manifold meshes; 'auto' takes 'robust' if it is needed.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [vallet2008], [ma2012]

        In scripts: 'Detail Enhancement'.
        """

    def apply_coord_developability_of_mesh(
        self,
        *,
        optmethod: Literal["[F] Fixed stepsize", "[B] Backtracking line search"] = "[B] Backtracking line search",
        maxfunevals: int = 400,
        eps: float = 1e-05,
        stepsize: float = 0.01,
        minstepsize: float = 1e-10,
        tau: float = 0.8,
        m1: float = 0.0001,
        edgeflips: bool = True,
        edgecollapses: bool = True,
        anglethreshold: float = 18.0,
    ) -> Any:
        """MeshLab's filter 'Make mesh developable'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_developability_of_mesh

        Args:
            optmethod: 'OptMethod' in scripts.
            maxfunevals: 'MaxFunEvals' in scripts. Takes a whole number from 0 to 100000.
            eps: 'Eps' in scripts. Takes a number.
            stepsize: 'StepSize' in scripts. Takes a number.
            minstepsize: 'MinStepSize' in scripts. Takes a number.
            tau: 'Tau' in scripts. Takes a number.
            m1: 'M1' in scripts. Takes a number.
            edgeflips: 'EdgeFlips' in scripts.
            edgecollapses: 'EdgeCollapses' in scripts.
            anglethreshold: 'AngleThreshold' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_directional_preservation(
        self,
        *,
        attr_name: str = ...,
        viewpoint: PointLike = (0.0, 0.0, 0.0),
    ) -> Any:
        """MeshLab's filter 'Directional Geometry Preservation'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_directional_preservation

        Args:
            attr_name: 'attr_name' in scripts. Takes a text. By default MeshLab chooses it for the mesh.
            viewpoint: 'viewPoint' in scripts. Takes three finite numbers.

        Returns:
            What the filter reports, by name; None if it reports nothing.
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
        """Moves all vertices towards the weighted mean of their neighbours, in repeated steps.

        Simple and fast, but closed surfaces shrink; Taubin Fairing avoids this.

        Args:
            operator: How neighbours are weighted. 'uniform' evens out triangle sizes, as vertices drift along the surface;
                'inverse_length' and 'scale_dependent' keep uneven sampling; 'cotangent' and 'laplace_beltrami' move vertices
                along the normal; 'robust' also works on point clouds, slivers and non-manifold meshes.
            step: How far a vertex moves towards the mean of its neighbours, as a share, above 0 and at most 1; for
                'scale_dependent', 'laplace_beltrami' and 'robust' a diffusion time in squared mean edges, bounded by stability.
                Larger is smoother. Takes a number of at least 0.
            iterations: The number of steps. More steps smooth more. Takes a whole number from 0 to 100000.
            update: 'euler' uses the step. 'meshlab' is the rule of MeshLab's Laplacian Smooth: the mean includes the vertex
                itself, and the step is not used; only with the operators 'uniform' and 'cotangent'.
            border: How vertices on open borders move. 'fixed': they stay. 'along': they are smoothed as a curve, with only
                their neighbours on the border. 'free': they move like any other vertex, so that borders recede.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [taubin1995], [fujiwara1995], [desbrun1999], [sharp2020]

        In scripts: 'Explicit Smoothing'.
        """

    def apply_coord_fractal_displacement(
        self,
        *,
        maxheight: LengthLike = "2%",
        scale: float = 1.0,
        smoothingsteps: int = 5,
        seed: float = 2.0,
        algorithm: Literal[
            "fBM (fractal Brownian Motion)",
            "Standard multifractal",
            "Heterogeneous multifractal",
            "Hybrid multifractal terrain",
            "Ridged multifractal terrain",
        ] = "Ridged multifractal terrain",
        octaves: float = 8.0,
        lacunarity: float = 4.0,
        fractalincrement: float = 0.2,
        offset: float = 0.9,
        gain: float = 2.5,
        saveasquality: bool = False,
    ) -> Any:
        """MeshLab's filter 'Fractal Displacement'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_fractal_displacement

        Args:
            maxheight: 'maxHeight' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            scale: 'scale' in scripts. Takes a number from 0.0 to 10.0.
            smoothingsteps: 'smoothingSteps' in scripts. Takes a whole number from 0 to 100000.
            seed: 'seed' in scripts. Takes a number.
            algorithm: 'algorithm' in scripts.
            octaves: 'octaves' in scripts. Takes a number from 1.0 to 20.0.
            lacunarity: 'lacunarity' in scripts. Takes a number.
            fractalincrement: 'fractalIncrement' in scripts. Takes a number.
            offset: 'offset' in scripts. Takes a number.
            gain: 'gain' in scripts. Takes a number.
            saveasquality: 'saveAsQuality' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_hc_laplacian_smoothing(self) -> Any:
        """MeshLab's filter 'HC Laplacian Smooth'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_hc_laplacian_smoothing

        Returns:
            What the filter reports, by name; None if it reports nothing.
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
        keep_dimensions: bool = False,
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths strongly in one stable step: solves (M - t C) p' = M p, the surface after a diffusion time t.

        M: vertex areas; C: stiffness. Any step is stable. With 'cotangent' and 'robust' the sampling hardly matters.

        Args:
            operator: 'cotangent' is the Laplace-Beltrami operator for any triangulation; 'robust' is the same operator for
                slivers, non-manifold meshes and point clouds; 'uniform', 'inverse_length' and 'scale_dependent' need a time
                step.
            detail_size: Waves of this length keep half their amplitude: smaller details vanish, larger ones stay. Larger is
                smoother. 'auto' chooses the size for the noise of the mesh. Takes a length such as '1%' (of the bounding box's
                diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0, or 'auto'.
            time_step: The diffusion time of one iteration, in squared mean edges (a pure number for 'uniform' and
                'inverse_length'). Larger is smoother; any value is stable. 0: not used, the detail size decides. Takes a number
                of at least 0.
            iterations: With a detail size, more iterations make a sharper cutoff; with a time step, each iteration smooths
                further. Takes a whole number from 1 to 10000.
            flow: For several iterations: 'linear' keeps the operator of the input; 'mean_curvature' rebuilds it at each step;
                'conformalized' updates only the areas, so that thin parts do not pinch off.
            preserve_volume: Rescale every closed component about its centroid so that it keeps its volume, if all of its
                vertices may move. Not for point clouds.
            keep_dimensions: Undo the motion along the normals as far as neighbours move alike: limbs keep their thickness and
                the shape keeps its size, on open surfaces too. Not for point clouds.
            border: How vertices on open borders move. 'fixed': they stay. 'along': they are smoothed as a curve, with only
                their neighbours on the border. 'free': they move like any other vertex, so that borders recede.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [desbrun1999], [kazhdan2012], [sharp2020], [tukey1977]

        In scripts: 'Implicit Fairing'.
        """

    def apply_coord_laplacian_smoothing(
        self,
        *,
        stepsmoothnum: int = 3,
        boundary: bool = True,
        cotangentweight: bool = True,
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Laplacian Smooth'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_laplacian_smoothing

        Args:
            stepsmoothnum: 'stepSmoothNum' in scripts. Takes a whole number from 0 to 100000.
            boundary: 'Boundary' in scripts.
            cotangentweight: 'cotangentWeight' in scripts.
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_laplacian_smoothing_scale_dependent(
        self,
        *,
        stepsmoothnum: int = 3,
        delta: LengthLike = "0.1%",
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'ScaleDependent Laplacian Smooth'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_laplacian_smoothing_scale_dependent

        Args:
            stepsmoothnum: 'stepSmoothNum' in scripts. Takes a whole number from 0 to 100000.
            delta: 'delta' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_laplacian_smoothing_surface_preserving(
        self,
        *,
        selection: bool = False,
        angledeg: float = 0.5,
        iterations: int = 1,
    ) -> Any:
        """MeshLab's filter 'Laplacian Smooth (surface preserving)'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_laplacian_smoothing_surface_preserving

        Args:
            selection: 'selection' in scripts.
            angledeg: 'AngleDeg' in scripts. Takes a number.
            iterations: 'iterations' in scripts. Takes a whole number from 0 to 100000.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_normal_filtering(
        self,
        *,
        method: Literal["auto", "mean", "unilateral", "bilateral", "averaged", "guided"] = "auto",
        range_kernel: Literal[
            "auto", "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "auto",
        space_kernel: Literal[
            "auto", "constant", "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "auto",
        range_measure: Literal["auto", "euclidean", "angle", "squared"] = "auto",
        range_sigma: float | Literal["auto"] = "auto",
        range_floor: float | Literal["auto"] = "auto",
        space_sigma: float | Literal["auto"] = "auto",
        neighborhood: Literal["auto", "edge", "vertex", "two_ring", "three_ring", "radius", "geodesic"] = "auto",
        normal_iterations: int | Literal["auto"] = "auto",
        vertex_iterations: int | Literal["auto"] = "auto",
        outer_iterations: int | Literal["auto"] = "auto",
        vertex_update: Literal["auto", "sun", "ohtake", "conjugate_gradient"] = "auto",
        outliers: Literal["auto", "keep", "replace", "only"] = "auto",
        rounding: Literal["auto", "keep", "undo"] = "auto",
        relaxation: int | Literal["auto"] = "auto",
        relaxation_direction: Literal["auto", "all", "normal"] = "auto",
        choice: Literal["held_out", "fixed"] = "held_out",
        compare: bool = False,
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes noise and keeps edges: filters the face normals robustly, then moves the vertices to fit the filtered normals.

        Without parameters it tries many settings, and takes one of those with the least estimated error; given parameters keep
        their values. If all parameters of the normal filter and the vertex update are given, 'auto' means 'keep' for outliers
        and rounding, and 0 for relaxation. Returns the parameters in use, the kind and level of the noise, whether the choice
        is sure, the trials, the drift (mean displacement in mean edges), and how many faces are folded, before and after.

        Args:
            method: How a neighbouring face is weighted. 'mean': by its area, which rounds edges. 'unilateral': also by the
                deviation of its normal. 'bilateral': also by its distance. 'averaged': the same with the deviation of averaged
                normals, for strong noise; 'guided': with that of the normals of the most even patches, for sharp edges.
            range_kernel: How weight falls with the deviation of normals. 'truncated_l1', 'truncated_l2', 'tukey' and 'hampel'
                reach 0 and keep edges; 'huber', 'lorentzian' and 'gaussian' suit smooth shapes.
            space_kernel: How weight falls with distance; 'constant': not at all.
            range_measure: How the deviation of two normals is measured: 'euclidean', the length of their difference, up to 2;
                'angle' in radians; 'squared', the square of that length.
            range_sigma: The deviation of normals at which the range kernel falls, in units of range_measure; 0.5 is about 30
                degrees, 41 if squared. Larger smooths more, and across sharper edges. Takes a number of at least 0, or 'auto'.
            range_floor: Smaller deviations are raised to this value; 0.03 keeps 'l1' and 'truncated_l1' from giving nearly all
                weight to normals that agree by chance. Larger smooths more. Takes a number from 0 to 4, or 'auto'.
            space_sigma: The distance at which the space kernel falls, in mean distances between centres of adjacent triangles.
                Larger smooths larger details. Takes a number of at least 0, or 'auto'.
            neighborhood: The faces to average: across the edges, at the vertices, in two or three rings, or within twice the
                mean distance of centres. The distance is straight ('radius') or along the surface ('geodesic'), which does not
                jump across a thin wall. A larger neighbourhood smooths larger details and is slower.
            normal_iterations: How often the normals are filtered before the vertices follow. More iterations smooth more. Takes
                a whole number from 1 to 10000, or 'auto'.
            vertex_iterations: The number of steps of the vertices towards the filtered normals. More steps fit them more
                closely. Takes a whole number from 1 to 10000, or 'auto'.
            outer_iterations: The number of rounds of filtering normals and moving vertices; more rounds smooth more. 20 to 30
                rounds of one normal iteration keep edges better than one round of 20 iterations. 0: normals are not filtered.
                Takes a whole number from 0 to 10000, or 'auto'.
            vertex_update: How vertices follow: 'sun' to the mean of their projections onto the planes of their faces, 'ohtake'
                to the mean weighted by area, 'conjugate_gradient' by descent on the sum of squared deviations of normals.
            outliers: Vertices far from the surface, such as stray measurements: 'keep' filters them like the others, 'replace'
                first moves them to predicted places, 'only' moves them alone.
            rounding: Rounded coordinates, all or along one axis, such as depths of a camera: 'keep' filters them like noise,
                'undo' first moves them to a smoother surface within half a rounding step.
            relaxation: The number of pairs of Taubin steps, 0.5 and -0.53, before the filter. More pairs reduce noise that
                turns faces over, but round the edges, which the filter sharpens again. Takes a whole number from 0 to 10000, or
                'auto'.
            relaxation_direction: The direction of Taubin steps: 'all', or only along the 'normal', so that no vertex slides.
            choice: How automatic parameters are chosen. 'held_out': tries about 150 settings on the mesh, or on patches of a
                large mesh, and takes one of the settings with the least estimated error. 'fixed': takes all-round values
                without trials.
            compare: Also report the prediction errors of Taubin, implicit, bi-Laplacian and spectral smoothing at held-out
                vertices, each with its best amount, if the noise is independent. The filtered mesh is the same. No effect with
                'fixed', or if a value replaces an 'auto'.
            border: How vertices on open borders move: 'fixed' stay; 'along' move along the normal, in Taubin steps also along
                the surface but no further than others, so that the outline stays; 'free' move like any other vertex.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [zheng2011], [zhang2015], [sun2007], [ohtake2001], [belyaev2001], [yadav2021]

        In scripts: 'Normal Filtering'.
        """

    def apply_coord_point_cloud_movement_over_mesh(
        self,
        *,
        point_cloud: int = ...,
        target_mesh: int = ...,
        gravity_dir: PointLike = (0.0, -1.0, 0.0),
        force_dir: PointLike = (0.0, 0.0, 0.0),
        steps: int = 1,
        adhesion: float = 1.0,
        velocity: float = 0.0,
        mass: float = 1.0,
        colorize_mesh: bool = False,
    ) -> Any:
        """MeshLab's filter 'Points Cloud Movement'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_point_cloud_movement_over_mesh

        Args:
            point_cloud: 'point_cloud' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            target_mesh: 'target_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            gravity_dir: 'gravity_dir' in scripts. Takes three finite numbers.
            force_dir: 'force_dir' in scripts. Takes three finite numbers.
            steps: 'steps' in scripts. Takes a whole number from 0 to 100000.
            adhesion: 'adhesion' in scripts. Takes a number from 0.0 to 1.0.
            velocity: 'velocity' in scripts. Takes a number.
            mass: 'mass' in scripts. Takes a number.
            colorize_mesh: 'colorize_mesh' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_random_displacement(
        self,
        *,
        updatenormals: bool = True,
        displacement: LengthLike = "1%",
        randomseed: int = 0,
    ) -> Any:
        """MeshLab's filter 'Random Vertex Displacement'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_random_displacement

        Args:
            updatenormals: 'UpdateNormals' in scripts.
            displacement: 'Displacement' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or
                '0.3' (mesh units).
            randomseed: 'RandomSeed' in scripts. Takes a whole number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_region_fairing(
        self,
        *,
        energy: Literal["membrane", "thin_plate", "minimum_variation"] = "thin_plate",
        iterations: int = 1,
        remesh: bool = False,
    ) -> dict[str, Any] | None:
        """Replaces the selected part of a surface by the smoothest part that continues the surface around it.

        For dents, scars, bad fillings and seams. The selected vertices move; if no vertex is selected, those whose triangles
        are all selected. Other vertices, and open borders, stay. The energies read one, two or three rings of vertices around
        the region, so select all of the damage and one ring more. Returns how many vertices moved, and the solution's backward
        error, number of corrections, and last correction as a share of the region's diagonal. With `remesh`: numbers of old and
        new elements instead.

        Args:
            energy: 'membrane' is like a soap film, with a crease at the boundary; 'thin_plate' bends least and continues the
                surrounding tangent planes; 'minimum_variation' continues the curvatures too, so that round shapes stay round.
            iterations: How often to solve, each time with the areas and angles of the previous result. With more, the old shape
                matters less; once is usually enough. Remeshing takes at least three. Takes a whole number from 1 to 100.
            remesh: Also replace the triangles of the part by regular triangles as dense as those around, for rough damage. They
                come last and are selected. Their colours continue those around; each shows a single point of the texture.

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
        largest_size: LengthLike = "auto",
        modes: int = 0,
        gain: float = 2.0,
        order: int = 2,
        method: Literal["auto", "eigenvectors", "polynomial"] = "auto",
        operator: Literal["auto", "cotangent", "robust"] = "auto",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Removes, keeps or exaggerates details by their size, like an equaliser for sound.

        A surface is a sum of waves, the modes of its Laplace-Beltrami operator. The filter multiplies each mode by a factor
        that depends only on its wavelength. The centroids of components stay, and open borders become as smooth as the surface.
        Returns the method that ran (route), the number of modes or the degree of the polynomial or rational function, the
        wavelength at the cutoff, and an error estimate in mesh units.

        Args:
            response: 'low_pass' removes waves shorter than the detail size. 'enhance' multiplies the waves from the detail size
                to the largest size by the gain, and keeps all others; the detail size should exceed the size of the noise.
                'band_pass' keeps only this band, for inspection.
            detail_size: Waves of this length keep half their amplitude: smaller details vanish, larger ones stay. Larger is
                smoother. 'auto' chooses the size for the noise of the mesh. Takes a length such as '1%' (of the bounding box's
                diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0, or 'auto'.
            largest_size: The longest wave of the band of 'enhance' and 'band_pass'. Larger includes larger parts. 'auto': four
                detail sizes. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of
                at least 0.0, or 'auto'.
            modes: The number of modes (manifold harmonics), over all components; the last one's wavelength replaces the detail
                size. More keep finer features: 5 leave a blob, 500 most features. 0: not used, the detail size decides. Takes a
                whole number from 0 to 1000000.
            gain: The factor of 'enhance' for the waves of the band. Larger makes these details stronger; a gain below 1 weakens
                them. Takes a number from 0 to 10.
            order: How sharply the response falls at the detail size. 1 is diffusion; larger is sharper, slower, and leaves
                ripples beside edges. Not used with modes and the route 'eigenvectors'. Takes a whole number from 1 to 8.
            method: 'eigenvectors' computes the modes; 'polynomial' filters without them, far faster on large meshes; 'auto'
                computes modes only if their number is given and memory allows. The result names the method.
            operator: 'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same operator for slivers and
                non-manifold meshes; 'auto' takes 'robust' if it is needed.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [taubin1995], [vallet2008]

        In scripts: 'Spectral Filter'.
        """

    def apply_coord_spike_removal(
        self,
        *,
        steepness: float = 1.5,
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Moves single vertices that stand up like needles back among their neighbours; all other vertices keep every bit.

        Vertices on open borders and the apexes of cones stay. Returns the number of spikes.

        Args:
            steepness: A vertex is a spike if its distance from the mean of its neighbours exceeds this many times their spread.
                Larger removes only thinner spikes; below 1 corners of boxes may count as spikes. Takes a number of at least 0.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Remove Spikes'.
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
        """Improves the shape of triangles on the same surface: vertices move along it towards the mean of their neighbours.

        Open borders stay. No triangle folds over. Colours and texture coordinates move with their vertices. Triangles with
        flipped edges come last; they take colour and scalar from nearby old triangles, and their custom attributes are 0.
        Returns the mean triangle quality before and after (1 for equilateral triangles), the number of triangles changed by
        flips, the number of moved vertices and the largest displacement.

        Args:
            weight: How strongly vertices are held in place. Larger moves them less in each iteration. Takes a number from 1e-09
                to 1000000000.0.
            iterations: The number of steps. More give better triangles, up to a point, and take longer. Takes a whole number
                from 0 to 1000.
            max_deviation: The largest distance of the centres of triangles and edges from the input surface; at sharp edges a
                fifth of this value. Vertices stay on the surface. Larger allows better triangles where the surface is curved or
                has edges. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units) of at
                least 0.0.
            flip_edges: Before each step, flip edges where this improves the two adjacent triangles: for range maps and other
                grids. Not on textured meshes.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

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
        iterations: int | Literal["auto"] = 10,
        border: Literal["fixed", "along", "free"] = "along",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths without shrinking: each iteration is a smoothing step followed by a slightly longer step back.

        With 'uniform' it is MeshLab's Taubin Smooth, except at non-manifold edges, and on borders, where its step is 2/3 of
        ours.

        Args:
            operator: How neighbours are weighted. 'uniform' is Taubin's choice; 'inverse_length' keeps uneven sampling;
                'cotangent' moves vertices only along the normal.
            step: The smoothing step, above 0. Larger is smoother per iteration. Takes a number from 0 to 1.
            mu: The step back, which undoes the shrinking; it must be below -step. Nearer to -step smooths more; not used when a
                pass band is given. Only for Taubin's method. Takes a number from -1.5 to 0.
            pass_band: Frequencies below it are kept, above it damped; on the operator's scale from 0 to 2, typically 0.01 to
                0.1. Smaller is smoother. 0: not used, mu decides. A pass band sets mu = 1 / (pass band - 1 / step). Takes a
                number from 0 to 2.
            iterations: The number of step pairs. More pairs smooth more. 'auto' chooses the number for the noise of the mesh.
                Takes a whole number from 0 to 100000, or 'auto'.
            border: How vertices on open borders move. 'fixed': they stay. 'along': they are smoothed as a curve, with only
                their neighbours on the border. 'free': they move like any other vertex, so that borders recede.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [taubin1995]

        In scripts: 'Taubin Fairing'.
        """

    def apply_coord_taubin_smoothing(
        self,
        *,
        lambda_: float = 0.5,
        mu: float = -0.53,
        stepsmoothnum: int = 10,
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Taubin Smooth'.

        Menus: smoothing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_taubin_smoothing

        Args:
            lambda_: 'lambda' in scripts. Takes a number.
            mu: 'mu' in scripts. Takes a number.
            stepsmoothnum: 'stepSmoothNum' in scripts. Takes a whole number from 0 to 100000.
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_two_steps_smoothing(
        self,
        *,
        stepsmoothnum: int = 3,
        normalthr: float = 60.0,
        stepnormalnum: int = 20,
        stepfitnum: int = 20,
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'TwoStep Smooth'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_two_steps_smoothing

        Args:
            stepsmoothnum: 'stepSmoothNum' in scripts. Takes a whole number from 0 to 100000.
            normalthr: 'normalThr' in scripts. Takes a number.
            stepnormalnum: 'stepNormalNum' in scripts. Takes a whole number from 0 to 100000.
            stepfitnum: 'stepFitNum' in scripts. Takes a whole number from 0 to 100000.
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_coord_unsharp_mask(
        self,
        *,
        weight: float = 0.3,
        weightorig: float = 1.0,
        iterations: int = 5,
    ) -> Any:
        """MeshLab's filter 'UnSharp Mask Geometry'.

        Menus: smoothing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_coord_unsharp_mask

        Args:
            weight: 'weight' in scripts. Takes a number.
            weightorig: 'weightOrig' in scripts. Takes a number.
            iterations: 'iterations' in scripts. Takes a whole number from 0 to 100000.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_matrix_flip_or_swap_axis(
        self,
        *,
        flipx: bool = False,
        flipy: bool = False,
        flipz: bool = False,
        swapxy: bool = False,
        swapxz: bool = False,
        swapyz: bool = False,
        freeze: bool = True,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform: Flip and/or swap axis'.

        Menus: normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_matrix_flip_or_swap_axis

        Args:
            flipx: 'flipX' in scripts.
            flipy: 'flipY' in scripts.
            flipz: 'flipZ' in scripts.
            swapxy: 'swapXY' in scripts.
            swapxz: 'swapXZ' in scripts.
            swapyz: 'swapYZ' in scripts.
            freeze: 'Freeze' in scripts.
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_matrix_freeze(
        self,
        *,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Matrix: Freeze Current Matrix'.

        Menus: layer, normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_matrix_freeze

        Args:
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_matrix_inverse(
        self,
        *,
        freeze: bool = True,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Matrix: Invert Current Matrix'.

        Menus: layer, normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_matrix_inverse

        Args:
            freeze: 'Freeze' in scripts.
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_normal_normalization_per_face(self) -> Any:
        """MeshLab's filter 'Normalize Face Normals'.

        Menus: normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_normal_normalization_per_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_normal_normalization_per_vertex(self) -> Any:
        """MeshLab's filter 'Normalize Vertex Normals'.

        Menus: normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_normal_normalization_per_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_normal_point_cloud_smoothing(
        self,
        *,
        k: int = 10,
        usedist: bool = False,
    ) -> Any:
        """MeshLab's filter 'Smooth normals on point sets'.

        Menus: normal, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_normal_point_cloud_smoothing

        Args:
            k: 'K' in scripts. Takes a whole number of at least 1.
            usedist: 'useDist' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_normal_robust_filtering_per_face(
        self,
        *,
        method: Literal["auto", "mean", "unilateral", "bilateral", "averaged", "guided"] = "auto",
        range_kernel: Literal[
            "auto", "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "auto",
        space_kernel: Literal[
            "auto", "constant", "l2", "l1", "truncated_l2", "truncated_l1", "huber", "lorentzian", "gaussian", "tukey", "hampel"
        ] = "auto",
        range_measure: Literal["auto", "euclidean", "angle", "squared"] = "auto",
        range_sigma: float | Literal["auto"] = "auto",
        range_floor: float | Literal["auto"] = "auto",
        space_sigma: float | Literal["auto"] = "auto",
        neighborhood: Literal["auto", "edge", "vertex", "two_ring", "three_ring", "radius", "geodesic"] = "auto",
        normal_iterations: int | Literal["auto"] = "auto",
        choice: Literal["held_out", "fixed"] = "held_out",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Averages the normals of the faces without rounding edges, and leaves the vertices where they are.

        This is the first half of Normal Filtering, for shading and filters that read face normals. The automatic number of
        normal iterations is the total over all its rounds. Returns the parameters in use, and the noise and trials of a choice.

        Args:
            method: How a neighbouring face is weighted. 'mean': by its area, which rounds edges. 'unilateral': also by the
                deviation of its normal. 'bilateral': also by its distance. 'averaged': the same with the deviation of averaged
                normals, for strong noise; 'guided': with that of the normals of the most even patches, for sharp edges.
            range_kernel: How weight falls with the deviation of normals. 'truncated_l1', 'truncated_l2', 'tukey' and 'hampel'
                reach 0 and keep edges; 'huber', 'lorentzian' and 'gaussian' suit smooth shapes.
            space_kernel: How weight falls with distance; 'constant': not at all.
            range_measure: How the deviation of two normals is measured: 'euclidean', the length of their difference, up to 2;
                'angle' in radians; 'squared', the square of that length.
            range_sigma: The deviation of normals at which the range kernel falls, in units of range_measure; 0.5 is about 30
                degrees, 41 if squared. Larger smooths more, and across sharper edges. Takes a number of at least 0, or 'auto'.
            range_floor: Smaller deviations are raised to this value; 0.03 keeps 'l1' and 'truncated_l1' from giving nearly all
                weight to normals that agree by chance. Larger smooths more. Takes a number from 0 to 4, or 'auto'.
            space_sigma: The distance at which the space kernel falls, in mean distances between centres of adjacent triangles.
                Larger smooths larger details. Takes a number of at least 0, or 'auto'.
            neighborhood: The faces to average: across the edges, at the vertices, in two or three rings, or within twice the
                mean distance of centres. The distance is straight ('radius') or along the surface ('geodesic'), which does not
                jump across a thin wall. A larger neighbourhood smooths larger details and is slower.
            normal_iterations: How often the normals are filtered before the vertices follow. More iterations smooth more. Takes
                a whole number from 1 to 10000, or 'auto'.
            choice: How automatic parameters are chosen. 'held_out': tries about 150 settings on the mesh, or on patches of a
                large mesh, and takes one of the settings with the least estimated error. 'fixed': takes all-round values
                without trials.
            selected: Only the selected faces get a new normal; the other faces keep their normals, and still count as
                neighbours.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [zheng2011], [zhang2015], [belyaev2001], [yadav2021]

        In scripts: 'Robust Filtering of Face Normals'.
        """

    def apply_normal_smoothing_per_face(self) -> Any:
        """MeshLab's filter 'Smooth Face Normals'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_normal_smoothing_per_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_normal_unsharp_mask_per_vertex(
        self,
        *,
        recalc: bool = False,
        weight: float = 0.3,
        weightorig: float = 1.0,
        iterations: int = 5,
    ) -> Any:
        """MeshLab's filter 'UnSharp Mask Normals'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_normal_unsharp_mask_per_vertex

        Args:
            recalc: 'recalc' in scripts.
            weight: 'weight' in scripts. Takes a number.
            weightorig: 'weightOrig' in scripts. Takes a number.
            iterations: 'iterations' in scripts. Takes a whole number from 0 to 100000.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_scalar_anisotropic_diffusion_per_vertex(
        self,
        *,
        range_kernel: Literal["lorentzian", "gaussian", "tukey", "huber", "hampel", "truncated_l2", "l2"] = "lorentzian",
        range_sigma: float | Literal["auto"] = "auto",
        step: float = 1.0,
        iterations: int = 10,
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Smooths the vertex scalar, not the mesh, and keeps its edges (jumps), as Perona and Malik did for images.

        Args:
            range_kernel: How the flow between neighbours falls with x, their difference divided by range sigma. 'lorentzian', 1
                / (1 + x^2), and 'gaussian', exp(-x^2), are the kernels of Perona and Malik; 'tukey' and 'truncated_l2' stop the
                flow at x = 1, 'hampel' at 4; 'huber' slows it; 'l2' smooths across edges.
            range_sigma: Differences between neighbours above this value are edges, and are kept. Larger smooths stronger noise
                and blurs more edges. 'auto' estimates it from the median difference. Takes a number of at least 0, or 'auto'.
            step: The step as a share of the largest stable step, which is one over the largest number of neighbours of a
                vertex. Larger is smoother per iteration. Takes a number from 0 to 1.
            iterations: The number of steps. More steps smooth more. Takes a whole number from 0 to 100000.
            selected: Only the selected vertices change; other vertices stay, and still count as neighbours. If no vertex is
                selected, the vertices whose triangles are all selected change.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [perona1990], [black1998]

        In scripts: 'Anisotropic Diffusion of Vertex Scalars'.
        """

    def apply_scalar_clamping_per_vertex(
        self,
        *,
        minval: float = ...,
        maxval: float = ...,
        perc: float = 0.0,
        zerosym: bool = False,
    ) -> Any:
        """MeshLab's filter 'Clamp Vertex Quality'.

        Menus: quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_scalar_clamping_per_vertex

        Args:
            minval: 'minVal' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            maxval: 'maxVal' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            perc: 'perc' in scripts. Takes a number from 0.0 to 100.0.
            zerosym: 'zeroSym' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_scalar_saturation_per_vertex(
        self,
        *,
        gradientthr: float = 1.0,
        updatecolor: bool = False,
    ) -> Any:
        """MeshLab's filter 'Saturate Vertex Quality'.

        Menus: quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_scalar_saturation_per_vertex

        Args:
            gradientthr: 'gradientThr' in scripts. Takes a number.
            updatecolor: 'updateColor' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_scalar_smoothing_per_vertex(self) -> Any:
        """MeshLab's filter 'Smooth Vertex Quality'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_scalar_smoothing_per_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_scalar_unsharp_mask_per_vertex(
        self,
        *,
        weight: float = 0.3,
        weightorig: float = 1.0,
        iterations: int = 5,
    ) -> Any:
        """MeshLab's filter 'UnSharp Mask Quality'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_scalar_unsharp_mask_per_vertex

        Args:
            weight: 'weight' in scripts. Takes a number.
            weightorig: 'weightOrig' in scripts. Takes a number.
            iterations: 'iterations' in scripts. Takes a whole number from 0 to 100000.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_selection_by_same_connected_component(self) -> Any:
        """MeshLab's filter 'Select Connected Faces'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_selection_by_same_connected_component

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_selection_dilatation(self) -> Any:
        """MeshLab's filter 'Dilate Selection'.

        Menus: selection. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_selection_dilatation

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_selection_erosion(self) -> Any:
        """MeshLab's filter 'Erode Selection'.

        Menus: selection. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_selection_erosion

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_selection_inverse(
        self,
        *,
        invfaces: bool = ...,
        invverts: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Invert Selection'.

        Menus: selection. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_selection_inverse

        Args:
            invfaces: 'InvFaces' in scripts. By default MeshLab chooses it for the mesh.
            invverts: 'InvVerts' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_texcoord_merge_per_wedge(
        self,
        *,
        mergethr: float = 0.0001,
    ) -> Any:
        """MeshLab's filter 'Merge Wedge Texture Coord'.

        Menus: cleaning, texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_texcoord_merge_per_wedge

        Args:
            mergethr: 'MergeThr' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def apply_texmap_defragmentation(
        self,
        *,
        matchingthreshold: float = 2.0,
        boundarytolerance: float = 0.2,
        distortiontolerance: float = 0.5,
        globaldistortiontolerance: float = 0.025,
        uvreductionlimit: float = 0.0,
        offsetfactor: float = 5.0,
        timelimit: float = 0.0,
    ) -> Any:
        """MeshLab's filter 'Texture Map Defragmentation'.

        Menus: texture. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#apply_texmap_defragmentation

        Args:
            matchingthreshold: 'matchingThreshold' in scripts. Takes a number.
            boundarytolerance: 'boundaryTolerance' in scripts. Takes a number.
            distortiontolerance: 'distortionTolerance' in scripts. Takes a number.
            globaldistortiontolerance: 'globalDistortionTolerance' in scripts. Takes a number.
            uvreductionlimit: 'uvReductionLimit' in scripts. Takes a number from 0.0 to 100.0.
            offsetfactor: 'offsetFactor' in scripts. Takes a number.
            timelimit: 'timelimit' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_and_texture_from_active_rasters_projection(
        self,
        *,
        textname: str = ...,
        texsize: int = 1024,
        dorefill: bool = True,
        deptheta: float = 0.5,
        onselection: bool = False,
        useangle: bool = True,
        usedistance: bool = True,
        useborders: bool = True,
        usesilhouettes: bool = True,
        usealpha: bool = False,
    ) -> Any:
        """MeshLab's filter 'Project active rasters color to current mesh, filling the texture'.

        Menus: texture, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_and_texture_from_active_rasters_projection

        Args:
            textname: 'textName' in scripts. Takes a text. By default MeshLab chooses it for the mesh.
            texsize: 'texsize' in scripts. Takes a whole number of at least 0.
            dorefill: 'dorefill' in scripts.
            deptheta: 'deptheta' in scripts. Takes a number.
            onselection: 'onselection' in scripts.
            useangle: 'useangle' in scripts.
            usedistance: 'usedistance' in scripts.
            useborders: 'useborders' in scripts.
            usesilhouettes: 'usesilhouettes' in scripts.
            usealpha: 'usealpha' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_by_conntected_component_per_face(self) -> Any:
        """MeshLab's filter 'Random Component Color'.

        Menus: face coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_by_conntected_component_per_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_by_function_per_face(
        self,
        *,
        r: str = "255",
        g: str = "0",
        b: str = "255",
        a: str = "255",
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Per Face Color Function'.

        Menus: face coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_by_function_per_face

        Args:
            r: 'r' in scripts. Takes a text.
            g: 'g' in scripts. Takes a text.
            b: 'b' in scripts. Takes a text.
            a: 'a' in scripts. Takes a text.
            onselected: 'onselected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_by_function_per_vertex(
        self,
        *,
        x: str = "255",
        y: str = "255",
        z: str = "0",
        a: str = "255",
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Per Vertex Color Function'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_by_function_per_vertex

        Args:
            x: 'x' in scripts. Takes a text.
            y: 'y' in scripts. Takes a text.
            z: 'z' in scripts. Takes a text.
            a: 'a' in scripts. Takes a text.
            onselected: 'onselected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_by_point_cloud_voronoi_projection(
        self,
        *,
        coloredmesh: int = ...,
        vertexmesh: int = ...,
        backward: bool = False,
    ) -> Any:
        """MeshLab's filter 'Voronoi Vertex Coloring'.

        Menus: vertex coloring, sampling. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_by_point_cloud_voronoi_projection

        Args:
            coloredmesh: 'ColoredMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            vertexmesh: 'VertexMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            backward: 'backward' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_by_reflection_lines_per_vertex(
        self,
        *,
        stripes: float = 8.0,
        direction: PointLike = (0.0, 1.0, 0.0),
        view: PointLike = (0.0, 0.0, 1.0),
    ) -> dict[str, Any] | None:
        """Colours the vertices like a polished surface in a hall of parallel lamps.

        The lines jump at creases, and bend sharply where the curvature jumps. The brightness, from 0 to 1, becomes the vertex
        scalar.

        Args:
            stripes: The number of lamps all round. More lamps show smaller defects, down to the length of the edges. Takes a
                number from 1 to 200.
            direction: The direction along the lamps, which are parallel and infinitely far. Takes three finite numbers.
            view: The direction from the mesh to the eye. Takes three finite numbers.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Reflection Lines'.
        """

    def compute_color_from_active_rasters_projection(
        self,
        *,
        deptheta: float = 0.5,
        onselection: bool = False,
        useangle: bool = True,
        usedistance: bool = True,
        useborders: bool = True,
        usesilhouettes: bool = True,
        usealpha: bool = False,
        blankcolor: ColorLike = (0, 0, 0, 255),
    ) -> Any:
        """MeshLab's filter 'Project active rasters color to current mesh'.

        Menus: vertex coloring, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_from_active_rasters_projection

        Args:
            deptheta: 'deptheta' in scripts. Takes a number.
            onselection: 'onselection' in scripts.
            useangle: 'useangle' in scripts.
            usedistance: 'usedistance' in scripts.
            useborders: 'useborders' in scripts.
            usesilhouettes: 'usesilhouettes' in scripts.
            usealpha: 'usealpha' in scripts.
            blankcolor: 'blankColor' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue, opacity).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_from_current_raster_projection(
        self,
        *,
        usedepth: bool = True,
        deptheta: float = 0.5,
        onselection: bool = False,
        blankcolor: ColorLike = (0, 0, 0, 255),
    ) -> Any:
        """MeshLab's filter 'Project current raster color to current mesh'.

        Menus: vertex coloring, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_from_current_raster_projection

        Args:
            usedepth: 'usedepth' in scripts.
            deptheta: 'deptheta' in scripts. Takes a number.
            onselection: 'onselection' in scripts.
            blankcolor: 'blankColor' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue, opacity).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_from_scalar_per_face(
        self,
        *,
        minval: float = ...,
        maxval: float = ...,
        perc: float = 0.0,
        zerosym: bool = False,
        colormap: Literal["RGB", "Viridis", "Plasma", "Cividis", "Turbo", "RdPu"] = "RGB",
    ) -> Any:
        """MeshLab's filter 'Colorize by face Quality'.

        Menus: face coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_from_scalar_per_face

        Args:
            minval: 'minVal' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            maxval: 'maxVal' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            perc: 'perc' in scripts. Takes a number from 0.0 to 100.0.
            zerosym: 'zeroSym' in scripts.
            colormap: 'colorMap' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_from_scalar_per_vertex(
        self,
        *,
        minval: float = ...,
        maxval: float = ...,
        perc: float = 0.0,
        zerosym: bool = False,
        colormap: Literal["RGB", "Viridis", "Plasma", "Cividis", "Turbo", "RdPu"] = "RGB",
    ) -> Any:
        """MeshLab's filter 'Colorize by vertex Quality'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_from_scalar_per_vertex

        Args:
            minval: 'minVal' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            maxval: 'maxVal' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            perc: 'perc' in scripts. Takes a number from 0.0 to 100.0.
            zerosym: 'zeroSym' in scripts.
            colormap: 'colorMap' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_from_scalar_using_transfer_function_per_vertex(
        self,
        *,
        minqualityval: float = ...,
        maxqualityval: float = ...,
        midhandlepos: float = 50.0,
        brightness: float = 1.0,
        tfslist: Literal[
            "Custom Transfer Function File",
            "Meshlab RGB",
            "RGB",
            "French RGB",
            "Red Scale",
            "Green Scale",
            "Blue Scale",
            "Flat",
            "Saw 4",
            "Saw 8",
            "Grey Scale",
        ] = "Meshlab RGB",
        csvfilename: str = "",
    ) -> Any:
        """MeshLab's filter 'Quality Mapper applier'.

        Menus: quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_from_scalar_using_transfer_function_per_vertex

        Args:
            minqualityval: 'minQualityVal' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            maxqualityval: 'maxQualityVal' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            midhandlepos: 'midHandlePos' in scripts. Takes a number.
            brightness: 'brightness' in scripts. Takes a number.
            tfslist: 'TFsList' in scripts.
            csvfilename: 'csvFileName' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_from_texture_per_vertex(self) -> Any:
        """MeshLab's filter 'Transfer Color: Texture to Vertex'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_from_texture_per_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_perlin_noise_per_vertex(
        self,
        *,
        color1: ColorLike = (0, 0, 0, 255),
        color2: ColorLike = (255, 255, 255, 255),
        freq: float = 10.0,
        offset: PointLike = (0.0, 0.0, 0.0),
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Perlin color'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_perlin_noise_per_vertex

        Args:
            color1: 'color1' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue, opacity).
            color2: 'color2' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue, opacity).
            freq: 'freq' in scripts. Takes a number from 0.1 to 100.0.
            offset: 'offset' in scripts. Takes three finite numbers.
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_random_per_face(self) -> Any:
        """MeshLab's filter 'Random Face Color'.

        Menus: face coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_random_per_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_scattering_per_mesh(
        self,
        *,
        seed: int = 0,
    ) -> Any:
        """MeshLab's filter 'PerMesh Color Scattering'.

        Menus: mesh coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_scattering_per_mesh

        Args:
            seed: 'seed' in scripts. Takes a whole number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_transfer_face_to_vertex(self) -> Any:
        """MeshLab's filter 'Transfer Color: Face to Vertex'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_transfer_face_to_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_transfer_mesh_to_face(
        self,
        *,
        allvisiblemesh: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transfer Color: Mesh to Face'.

        Menus: face coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_transfer_mesh_to_face

        Args:
            allvisiblemesh: 'allVisibleMesh' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_color_transfer_vertex_to_face(self) -> Any:
        """MeshLab's filter 'Transfer Color: Vertex to Face'.

        Menus: face coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_color_transfer_vertex_to_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_coord_by_function(
        self,
        *,
        x: str = "x",
        y: str = "y",
        z: str = "sin(x+y)",
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Per Vertex Geometric Function'.

        Menus: smoothing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_coord_by_function

        Args:
            x: 'x' in scripts. Takes a text.
            y: 'y' in scripts. Takes a text.
            z: 'z' in scripts. Takes a text.
            onselected: 'onselected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_coord_linear_morphing(
        self,
        *,
        targetmesh: int = ...,
        percentmorph: float = 0.0,
    ) -> Any:
        """MeshLab's filter 'Vertex Linear Morphing'.

        Menus: smoothing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_coord_linear_morphing

        Args:
            targetmesh: 'TargetMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            percentmorph: 'PercentMorph' in scripts. Takes a number from -150.0 to 250.0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_curvature_and_color_apss_per_vertex(
        self,
        *,
        filterscale: float = 2.0,
        projectionaccuracy: float = 0.0001,
        maxprojectioniters: int = 15,
        sphericalparameter: float = 1.0,
        selectiononly: bool = False,
        curvaturetype: Literal["Mean", "Gauss", "K1", "K2", "ApproxMean"] = "Mean",
    ) -> Any:
        """MeshLab's filter 'Colorize curvature (APSS)'.

        Menus: vertex coloring, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_curvature_and_color_apss_per_vertex

        Args:
            filterscale: 'FilterScale' in scripts. Takes a number.
            projectionaccuracy: 'ProjectionAccuracy' in scripts. Takes a number.
            maxprojectioniters: 'MaxProjectionIters' in scripts. Takes a whole number from 0 to 100000.
            sphericalparameter: 'SphericalParameter' in scripts. Takes a number.
            selectiononly: 'SelectionOnly' in scripts.
            curvaturetype: 'CurvatureType' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_curvature_and_color_rimls_per_vertex(
        self,
        *,
        filterscale: float = 2.0,
        projectionaccuracy: float = 0.0001,
        maxprojectioniters: int = 15,
        sigman: float = 0.75,
        maxrefittingiters: int = 3,
        selectiononly: bool = False,
        curvaturetype: Literal["Mean", "Gauss", "K1", "K2"] = "Mean",
    ) -> Any:
        """MeshLab's filter 'Colorize curvature (RIMLS)'.

        Menus: vertex coloring, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_curvature_and_color_rimls_per_vertex

        Args:
            filterscale: 'FilterScale' in scripts. Takes a number.
            projectionaccuracy: 'ProjectionAccuracy' in scripts. Takes a number.
            maxprojectioniters: 'MaxProjectionIters' in scripts. Takes a whole number from 0 to 100000.
            sigman: 'SigmaN' in scripts. Takes a number.
            maxrefittingiters: 'MaxRefittingIters' in scripts. Takes a whole number from 0 to 100000.
            selectiononly: 'SelectionOnly' in scripts.
            curvaturetype: 'CurvatureType' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_curvature_principal_directions_per_vertex(
        self,
        *,
        method: Literal[
            "Taubin approximation",
            "Principal Component Analysis",
            "Normal Cycles",
            "Quadric Fitting",
            "Scale Dependent Quadric Fitting",
        ] = "Quadric Fitting",
        curvcolormethod: Literal[
            "Mean Curvature", "Gaussian Curvature", "Min Curvature", "Max Curvature", "Shape Index", "CurvedNess", "None"
        ] = "Mean Curvature",
        scale: LengthLike = "10%",
        autoclean: bool = True,
    ) -> Any:
        """MeshLab's filter 'Compute curvature principal directions'.

        Menus: vertex coloring, normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_curvature_principal_directions_per_vertex

        Args:
            method: 'Method' in scripts.
            curvcolormethod: 'CurvColorMethod' in scripts.
            scale: 'Scale' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).
            autoclean: 'Autoclean' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_custom_radius_scalar_attribute_per_vertex(
        self,
        *,
        nbneighbors: int = 16,
    ) -> Any:
        """MeshLab's filter 'Estimate radius from density'.

        Menus: point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_custom_radius_scalar_attribute_per_vertex

        Args:
            nbneighbors: 'NbNeighbors' in scripts. Takes a whole number of at least 1.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_iso_parametrization(
        self,
        *,
        targetabstractminfacenum: int = 150,
        targetabstractmaxfacenum: int = 200,
        stopcriteria: Literal["Best Heuristic", "Area + Angle", "Regularity", "L2"] = "Area + Angle",
        convergencespeed: int = 1,
        doublestep: bool = True,
    ) -> Any:
        """MeshLab's filter 'Iso Parametrization: Main'.

        Menus: remeshing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_iso_parametrization

        Args:
            targetabstractminfacenum: 'targetAbstractMinFaceNum' in scripts. Takes a whole number of at least 0.
            targetabstractmaxfacenum: 'targetAbstractMaxFaceNum' in scripts. Takes a whole number of at least 0.
            stopcriteria: 'stopCriteria' in scripts.
            convergencespeed: 'convergenceSpeed' in scripts. Takes a whole number of at least 0.
            doublestep: 'DoubleStep' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_matrix_by_fitting_to_plane(
        self,
        *,
        targetplane: Literal["XY plane", "YZ plane", "ZX plane"] = "XY plane",
        rotaxis: Literal["any axis", "X axis", "Y axis", "Z axis"] = "any axis",
        toorigin: bool = True,
        freeze: bool = True,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform: Rotate to Fit to a plane'.

        Menus: normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_matrix_by_fitting_to_plane

        Args:
            targetplane: 'targetPlane' in scripts.
            rotaxis: 'rotAxis' in scripts.
            toorigin: 'ToOrigin' in scripts.
            freeze: 'Freeze' in scripts.
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_matrix_by_icp_between_meshes(
        self,
        *,
        referencemesh: int = ...,
        sourcemesh: int = ...,
        samplenum: int = 2000,
        mindistabs: float = 10.0,
        trgdistabs: float = 0.005,
        maxiternum: int = 75,
        samplemode: bool = True,
        reducefactorperc: float = 0.8,
        passhifilter: float = 0.75,
        matchmode: bool = True,
        savelastiteration: bool = False,
    ) -> Any:
        """MeshLab's filter 'ICP Between Meshes'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_matrix_by_icp_between_meshes

        Args:
            referencemesh: 'ReferenceMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it
                for the mesh.
            sourcemesh: 'SourceMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            samplenum: 'SampleNum' in scripts. Takes a whole number of at least 0.
            mindistabs: 'MinDistAbs' in scripts. Takes a number.
            trgdistabs: 'TrgDistAbs' in scripts. Takes a number.
            maxiternum: 'MaxIterNum' in scripts. Takes a whole number from 0 to 100000.
            samplemode: 'SampleMode' in scripts.
            reducefactorperc: 'ReduceFactorPerc' in scripts. Takes a number.
            passhifilter: 'PassHiFilter' in scripts. Takes a number.
            matchmode: 'MatchMode' in scripts.
            savelastiteration: 'SaveLastIteration' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_matrix_by_mesh_global_alignment(
        self,
        *,
        basemesh: int = ...,
        onlyvisiblemeshes: bool = False,
        ogsize: int = 50000,
        arcthreshold: float = 0.3,
        recalcthreshold: float = 0.1,
        samplenum: int = 2000,
        mindistabs: float = 10.0,
        trgdistabs: float = 0.005,
        maxiternum: int = 75,
        samplemode: bool = True,
        reducefactorperc: float = 0.8,
        passhifilter: float = 0.75,
        matchmode: bool = True,
    ) -> Any:
        """MeshLab's filter 'Global Align Meshes'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_matrix_by_mesh_global_alignment

        Args:
            basemesh: 'BaseMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            onlyvisiblemeshes: 'OnlyVisibleMeshes' in scripts.
            ogsize: 'OGSize' in scripts. Takes a whole number of at least 0.
            arcthreshold: 'arcThreshold' in scripts. Takes a number.
            recalcthreshold: 'recalcThreshold' in scripts. Takes a number.
            samplenum: 'SampleNum' in scripts. Takes a whole number of at least 0.
            mindistabs: 'MinDistAbs' in scripts. Takes a number.
            trgdistabs: 'TrgDistAbs' in scripts. Takes a number.
            maxiternum: 'MaxIterNum' in scripts. Takes a whole number from 0 to 100000.
            samplemode: 'SampleMode' in scripts.
            reducefactorperc: 'ReduceFactorPerc' in scripts. Takes a number.
            passhifilter: 'PassHiFilter' in scripts. Takes a number.
            matchmode: 'MatchMode' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_matrix_by_principal_axis(
        self,
        *,
        pointsflag: bool = True,
        freeze: bool = True,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform: Align to Principal Axis'.

        Menus: normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_matrix_by_principal_axis

        Args:
            pointsflag: 'pointsFlag' in scripts.
            freeze: 'Freeze' in scripts.
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_matrix_from_rotation(
        self,
        *,
        rotaxis: Literal["X axis", "Y axis", "Z axis", "custom axis"] = "X axis",
        rotcenter: Literal["origin", "barycenter", "custom point"] = "origin",
        angle: float = 0.0,
        customaxis: PointLike = (0.0, 0.0, 0.0),
        customcenter: PointLike = (0.0, 0.0, 0.0),
        snapflag: bool = False,
        snapangle: float = 30.0,
        freeze: bool = True,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform: Rotate'.

        Menus: normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_matrix_from_rotation

        Args:
            rotaxis: 'rotAxis' in scripts.
            rotcenter: 'rotCenter' in scripts.
            angle: 'angle' in scripts. Takes a number from -360.0 to 360.0.
            customaxis: 'customAxis' in scripts. Takes three finite numbers.
            customcenter: 'customCenter' in scripts. Takes three finite numbers.
            snapflag: 'snapFlag' in scripts.
            snapangle: 'snapAngle' in scripts. Takes a number.
            freeze: 'Freeze' in scripts.
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_matrix_from_scaling_or_normalization(
        self,
        *,
        axisx: float = 1.0,
        axisy: float = 1.0,
        axisz: float = 1.0,
        uniformflag: bool = True,
        scalecenter: Literal["origin", "barycenter", "custom point"] = "origin",
        customcenter: PointLike = (0.0, 0.0, 0.0),
        unitflag: bool = False,
        freeze: bool = True,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform: Scale, Normalize'.

        Menus: normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_matrix_from_scaling_or_normalization

        Args:
            axisx: 'axisX' in scripts. Takes a number.
            axisy: 'axisY' in scripts. Takes a number.
            axisz: 'axisZ' in scripts. Takes a number.
            uniformflag: 'uniformFlag' in scripts.
            scalecenter: 'scaleCenter' in scripts.
            customcenter: 'customCenter' in scripts. Takes three finite numbers.
            unitflag: 'unitFlag' in scripts.
            freeze: 'Freeze' in scripts.
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_matrix_from_translation(
        self,
        *,
        traslmethod: Literal[
            "XYZ translation", "Center on Scene BBox", "Center on Layer BBox", "Set new Origin"
        ] = "XYZ translation",
        axisx: float = 0.0,
        axisy: float = 0.0,
        axisz: float = 0.0,
        neworigin: PointLike = (0.0, 0.0, 0.0),
        freeze: bool = True,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Transform: Translate, Center, set Origin'.

        Menus: normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_matrix_from_translation

        Args:
            traslmethod: 'traslMethod' in scripts.
            axisx: 'axisX' in scripts. Takes a number.
            axisy: 'axisY' in scripts. Takes a number.
            axisz: 'axisZ' in scripts. Takes a number.
            neworigin: 'newOrigin' in scripts. Takes three finite numbers.
            freeze: 'Freeze' in scripts.
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_matrix_from_translation_rotation_scale(
        self,
        *,
        translationx: float = 0.0,
        translationy: float = 0.0,
        translationz: float = 0.0,
        rotationx: float = 0.0,
        rotationy: float = 0.0,
        rotationz: float = 0.0,
        scalex: float = 1.0,
        scaley: float = 1.0,
        scalez: float = 1.0,
        compose: bool = False,
        freeze: bool = True,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Matrix: Set from translation/rotation/scale'.

        Menus: layer, normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_matrix_from_translation_rotation_scale

        Args:
            translationx: 'translationX' in scripts. Takes a number.
            translationy: 'translationY' in scripts. Takes a number.
            translationz: 'translationZ' in scripts. Takes a number.
            rotationx: 'rotationX' in scripts. Takes a number.
            rotationy: 'rotationY' in scripts. Takes a number.
            rotationz: 'rotationZ' in scripts. Takes a number.
            scalex: 'scaleX' in scripts. Takes a number.
            scaley: 'scaleY' in scripts. Takes a number.
            scalez: 'scaleZ' in scripts. Takes a number.
            compose: 'compose' in scripts.
            freeze: 'Freeze' in scripts.
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_mls_projection_apss(
        self,
        *,
        controlmesh: int = ...,
        proxymesh: int = ...,
        selectiononly: bool = False,
        maxsubdivisions: int = 0,
        thangleindegree: float = 2.0,
        filterscale: float = 2.0,
        projectionaccuracy: float = 0.0001,
        maxprojectioniters: int = 15,
        sphericalparameter: float = 1.0,
        accuratenormal: bool = True,
    ) -> Any:
        """MeshLab's filter 'MLS projection (APSS)'.

        Menus: smoothing, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_mls_projection_apss

        Args:
            controlmesh: 'ControlMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            proxymesh: 'ProxyMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            selectiononly: 'SelectionOnly' in scripts.
            maxsubdivisions: 'MaxSubdivisions' in scripts. Takes a whole number of at least 0.
            thangleindegree: 'ThAngleInDegree' in scripts. Takes a number.
            filterscale: 'FilterScale' in scripts. Takes a number.
            projectionaccuracy: 'ProjectionAccuracy' in scripts. Takes a number.
            maxprojectioniters: 'MaxProjectionIters' in scripts. Takes a whole number from 0 to 100000.
            sphericalparameter: 'SphericalParameter' in scripts. Takes a number.
            accuratenormal: 'AccurateNormal' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_mls_projection_rimls(
        self,
        *,
        controlmesh: int = ...,
        proxymesh: int = ...,
        selectiononly: bool = False,
        maxsubdivisions: int = 0,
        thangleindegree: float = 2.0,
        filterscale: float = 2.0,
        projectionaccuracy: float = 0.0001,
        maxprojectioniters: int = 15,
        sigman: float = 0.75,
        maxrefittingiters: int = 3,
    ) -> Any:
        """MeshLab's filter 'MLS projection (RIMLS)'.

        Menus: smoothing, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_mls_projection_rimls

        Args:
            controlmesh: 'ControlMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            proxymesh: 'ProxyMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            selectiononly: 'SelectionOnly' in scripts.
            maxsubdivisions: 'MaxSubdivisions' in scripts. Takes a whole number of at least 0.
            thangleindegree: 'ThAngleInDegree' in scripts. Takes a number.
            filterscale: 'FilterScale' in scripts. Takes a number.
            projectionaccuracy: 'ProjectionAccuracy' in scripts. Takes a number.
            maxprojectioniters: 'MaxProjectionIters' in scripts. Takes a whole number from 0 to 100000.
            sigman: 'SigmaN' in scripts. Takes a number.
            maxrefittingiters: 'MaxRefittingIters' in scripts. Takes a whole number from 0 to 100000.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_new_custom_point_attribute_per_face(
        self,
        *,
        name: str = "CustomAttrName",
        x_expr: str = "x0",
        y_expr: str = "y0",
        z_expr: str = "z0",
    ) -> Any:
        """MeshLab's filter 'Define New Per Face Custom Point Attribute'.

        Menus: layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_new_custom_point_attribute_per_face

        Args:
            name: 'name' in scripts. Takes a text.
            x_expr: 'x_expr' in scripts. Takes a text.
            y_expr: 'y_expr' in scripts. Takes a text.
            z_expr: 'z_expr' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_new_custom_point_attribute_per_vertex(
        self,
        *,
        name: str = "CustomAttrName",
        x_expr: str = "x",
        y_expr: str = "y",
        z_expr: str = "z",
    ) -> Any:
        """MeshLab's filter 'Define New Per Vertex Custom Point Attribute'.

        Menus: layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_new_custom_point_attribute_per_vertex

        Args:
            name: 'name' in scripts. Takes a text.
            x_expr: 'x_expr' in scripts. Takes a text.
            y_expr: 'y_expr' in scripts. Takes a text.
            z_expr: 'z_expr' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_new_custom_scalar_attribute_per_face(
        self,
        *,
        name: str = "CustomAttrName",
        expr: str = "fi",
    ) -> Any:
        """MeshLab's filter 'Define New Per Face Custom Scalar Attribute'.

        Menus: layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_new_custom_scalar_attribute_per_face

        Args:
            name: 'name' in scripts. Takes a text.
            expr: 'expr' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_new_custom_scalar_attribute_per_vertex(
        self,
        *,
        name: str = "CustomAttrName",
        expr: str = "x",
    ) -> Any:
        """MeshLab's filter 'Define New Per Vertex Custom Scalar Attribute'.

        Menus: layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_new_custom_scalar_attribute_per_vertex

        Args:
            name: 'name' in scripts. Takes a text.
            expr: 'expr' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_normal_by_function_per_face(
        self,
        *,
        x: str = "-fnx",
        y: str = "-fny",
        z: str = "-fnz",
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Per Face Normal Function'.

        Menus: normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_normal_by_function_per_face

        Args:
            x: 'x' in scripts. Takes a text.
            y: 'y' in scripts. Takes a text.
            z: 'z' in scripts. Takes a text.
            onselected: 'onselected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_normal_by_function_per_vertex(
        self,
        *,
        x: str = "-nx",
        y: str = "-ny",
        z: str = "-nz",
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Per Vertex Normal Function'.

        Menus: normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_normal_by_function_per_vertex

        Args:
            x: 'x' in scripts. Takes a text.
            y: 'y' in scripts. Takes a text.
            z: 'z' in scripts. Takes a text.
            onselected: 'onselected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_normal_for_point_clouds(
        self,
        *,
        k: int = 10,
        smoothiter: int = 0,
        flipflag: bool = False,
        viewpos: PointLike = (0.0, 0.0, 0.0),
    ) -> Any:
        """MeshLab's filter 'Compute normals for point sets'.

        Menus: normal, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_normal_for_point_clouds

        Args:
            k: 'K' in scripts. Takes a whole number of at least 1.
            smoothiter: 'smoothIter' in scripts. Takes a whole number from 0 to 100000.
            flipflag: 'flipFlag' in scripts.
            viewpos: 'viewPos' in scripts. Takes three finite numbers.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_normal_from_cameras_per_vertex(self) -> Any:
        """MeshLab's filter 'Re-Orient vertex normals using cameras'.

        Menus: normal, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_normal_from_cameras_per_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_normal_per_face(self) -> Any:
        """MeshLab's filter 'Re-Compute Face Normals'.

        Menus: normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_normal_per_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_normal_per_vertex(
        self,
        *,
        weightmode: Literal["Simple Average", "By Area", "By Angle", "As defined by N. Max"] = "Simple Average",
    ) -> Any:
        """MeshLab's filter 'Re-Compute Vertex Normals'.

        Menus: normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_normal_per_vertex

        Args:
            weightmode: 'weightMode' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_normal_polygon_mesh_per_face(self) -> Any:
        """MeshLab's filter 'Re-Compute Per-Polygon Face Normals'.

        Menus: normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_normal_polygon_mesh_per_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_ambient_occlusion(
        self,
        *,
        rays: int = 64,
    ) -> Any:
        """MeshLab's filter 'Compute Ambient occlusion'.

        Menus: quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_ambient_occlusion

        Args:
            rays: 'Rays' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_ambient_occlusion_gpu(
        self,
        *,
        occmode: Literal["per-Vertex", "per-Face (deprecated)"] = "per-Vertex",
        dirbias: float = 0.0,
        reqviews: int = 128,
        conedir: PointLike = (0.0, 1.0, 0.0),
        coneangle: float = 30.0,
        usegpu: bool = False,
        depthtexsize: int = 512,
    ) -> Any:
        """MeshLab's filter 'Ambient Occlusion'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_ambient_occlusion_gpu

        Args:
            occmode: 'occMode' in scripts.
            dirbias: 'dirBias' in scripts. Takes a number.
            reqviews: 'reqViews' in scripts. Takes a whole number of at least 0.
            conedir: 'coneDir' in scripts. Takes three finite numbers.
            coneangle: 'coneAngle' in scripts. Takes a number.
            usegpu: 'useGPU' in scripts.
            depthtexsize: 'depthTexSize' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_aspect_ratio_per_face(
        self,
        *,
        metric: Literal[
            "area/max side",
            "inradius/circumradius",
            "Mean ratio",
            "Area",
            "Texture Angle Distortion",
            "Texture Area Distortion",
            "Polygonal planarity (max)",
            "Polygonal planarity (relative)",
        ] = "area/max side",
    ) -> Any:
        """MeshLab's filter 'Per Face Quality according to Triangle shape and aspect ratio'.

        Menus: face coloring, quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_aspect_ratio_per_face

        Args:
            metric: 'Metric' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_border_distance_per_vertex(self) -> Any:
        """MeshLab's filter 'Colorize by border distance'.

        Menus: vertex coloring, quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_border_distance_per_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_discrete_curvature_per_vertex(
        self,
        *,
        curvaturetype: Literal["Mean Curvature", "Gaussian Curvature", "RMS Curvature", "ABS Curvature"] = "Mean Curvature",
    ) -> Any:
        """MeshLab's filter 'Discrete Curvatures'.

        Menus: vertex coloring, normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_discrete_curvature_per_vertex

        Args:
            curvaturetype: 'CurvatureType' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_displacement_per_vertex(
        self,
        *,
        reference: int = 0,
        correspondence: Literal["auto", "vertex", "surface"] = "auto",
        signed: bool = True,
        color: bool = True,
    ) -> dict[str, Any] | None:
        """Gives every vertex its distance from another layer, for example to see what a clean-up has moved.

        In mesh units. Colours: blue below 0, nearly white at 0, orange above, or dark violet to yellow for unsigned values,
        between limits that enclose 98 % of the vertices. Returns the limits of the colours; the lowest, the highest and the
        mean value; the mean, root mean square, 95th percentile and largest distance; and whether vertices were compared by
        number.

        Args:
            reference: The layer from which the displacement is measured, such as the mesh before cleaning. Takes the id of a
                layer (a whole number).
            correspondence: 'vertex' measures from the vertex of the same number, 'surface' from the nearest place of the
                reference; 'auto' takes 'vertex' if both layers have equally many vertices, and the same faces, at least one.
            signed: Values are negative on the inner side of the reference; for 'vertex' they are components along its normals.
            color: Also colour the mesh by the scalar, which replaces its colours.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Displacement from Another Layer'.
        """

    def compute_scalar_by_distance_from_another_mesh_per_vertex(
        self,
        *,
        measuremesh: int = ...,
        refmesh: int = ...,
        signeddist: bool = True,
        maxdist: LengthLike = "100%",
    ) -> Any:
        """MeshLab's filter 'Distance from Reference Mesh'.

        Menus: sampling. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_distance_from_another_mesh_per_vertex

        Args:
            measuremesh: 'MeasureMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            refmesh: 'RefMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the mesh.
            signeddist: 'SignedDist' in scripts.
            maxdist: 'MaxDist' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_distance_from_point_cloud_per_vertex(
        self,
        *,
        coloredmesh: int = ...,
        vertexmesh: int = ...,
        radius: float = ...,
        sampleradius: bool = False,
        approximategeodetic: bool = False,
    ) -> Any:
        """MeshLab's filter 'Disk Vertex Coloring'.

        Menus: vertex coloring, sampling. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_distance_from_point_cloud_per_vertex

        Args:
            coloredmesh: 'ColoredMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            vertexmesh: 'VertexMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            radius: 'Radius' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            sampleradius: 'SampleRadius' in scripts.
            approximategeodetic: 'ApproximateGeodetic' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_function_per_face(
        self,
        *,
        q: str = "x0+y0+z0",
        normalize: bool = False,
        map: bool = False,
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Per Face Quality Function'.

        Menus: face coloring, quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_function_per_face

        Args:
            q: 'q' in scripts. Takes a text.
            normalize: 'normalize' in scripts.
            map: 'map' in scripts.
            onselected: 'onselected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_function_per_vertex(
        self,
        *,
        q: str = "vi",
        normalize: bool = False,
        map: bool = False,
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Per Vertex Quality Function'.

        Menus: vertex coloring, quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_function_per_vertex

        Args:
            q: 'q' in scripts. Takes a text.
            normalize: 'normalize' in scripts.
            map: 'map' in scripts.
            onselected: 'onselected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_gaussian_curvature_per_vertex(
        self,
        *,
        measure: Literal["per_area", "deficit"] = "per_area",
        color: bool = True,
    ) -> dict[str, Any] | None:
        """Gives every vertex its Gaussian curvature: 1/r^2 on a sphere of radius r, 0 on cylinders and planes, negative on
        saddles.

        Colours: blue on saddles, nearly white on developable parts, orange on domes and in bowls, between limits that enclose
        98 % of the vertices. On borders the curvature is 0, and the deficit is the angle by which the border turns. Returns the
        limits of the colours; the lowest, the highest and the mean value; and the sum.

        Args:
            measure: 'per_area' is the curvature, in 1 / squared mesh unit; 'deficit' is the angle deficit of the vertex, in
                radians.
            color: Also colour the mesh by the scalar, which replaces its colours.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [meyer2003]

        In scripts: 'Gaussian Curvature by Angle Deficit'.
        """

    def compute_scalar_by_geodesic_distance_from_given_point_per_vertex(
        self,
        *,
        startpoint: PointLike = ...,
        maxdistance: LengthLike = "100%",
    ) -> Any:
        """MeshLab's filter 'Colorize by geodesic distance from a given point'.

        Menus: vertex coloring, quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_geodesic_distance_from_given_point_per_vertex

        Args:
            startpoint: 'startPoint' in scripts. Takes three finite numbers. By default MeshLab chooses it for the mesh.
            maxdistance: 'maxDistance' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or
                '0.3' (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_geodesic_distance_from_selection_per_vertex(
        self,
        *,
        maxdistance: LengthLike = "100%",
    ) -> Any:
        """MeshLab's filter 'Colorize by geodesic distance from the selected points'.

        Menus: vertex coloring, quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_geodesic_distance_from_selection_per_vertex

        Args:
            maxdistance: 'maxDistance' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or
                '0.3' (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_heat_geodesic_distance_from_selection_per_vertex(
        self,
        *,
        m: float = 1.0,
    ) -> Any:
        """MeshLab's filter 'Colorize by approximated geodesic distance from the selected points'.

        Menus: vertex coloring, quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_heat_geodesic_distance_from_selection_per_vertex

        Args:
            m: 'm' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_manifold_harmonic_per_vertex(
        self,
        *,
        mode: int = 10,
        operator: Literal["auto", "cotangent", "robust"] = "auto",
    ) -> dict[str, Any] | None:
        """Writes a mode of the surface, one of the waves that spectral filters keep or remove, to the vertex scalar for
        inspection.

        Modes are eigenfunctions of the Laplace-Beltrami operator. Mode 0 is constant; other modes are 0 outside one component.
        Modes are 0 at vertices without a triangle; the mean square of a mode over the surface is 1, its sign is reproducible.
        Returns the frequency f (radians per mesh unit), the wavelength (2 pi / f) and the eigenvalue (f squared).

        Args:
            mode: The number of the mode, by rising frequency over all components. 0 is constant, 1 is the longest wave; a
                larger number has shorter waves and takes longer. Takes a whole number from 0 to 1000000.
            operator: 'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same operator for slivers and
                non-manifold meshes; 'auto' takes 'robust' if it is needed.

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

        In 1 / mesh unit; 0 on borders. Colours: blue in hollows, nearly white on flat parts, orange on bulges, between limits
        that enclose 98 % of the vertices. Returns the limits of the colours, and the lowest, the highest and the mean value.

        Args:
            operator: 'cotangent' allows for triangle shapes; 'uniform' is robust to slivers, but wrong for unevenly spread
                vertices.
            color: Also colour the mesh by the scalar, which replaces its colours.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [meyer2003]

        In scripts: 'Mean Curvature by Laplacian'.
        """

    def compute_scalar_by_scalar_harmonic_field_per_vertex(
        self,
        *,
        point1: PointLike = ...,
        point2: PointLike = ...,
        value1: float = 0.0,
        value2: float = 1.0,
        colorize: bool = True,
    ) -> Any:
        """MeshLab's filter 'Generate Scalar Harmonic Field'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_scalar_harmonic_field_per_vertex

        Args:
            point1: 'point1' in scripts. Takes three finite numbers. By default MeshLab chooses it for the mesh.
            point2: 'point2' in scripts. Takes three finite numbers. By default MeshLab chooses it for the mesh.
            value1: 'value1' in scripts. Takes a number from 0.0 to 1.0.
            value2: 'value2' in scripts. Takes a number from 0.0 to 1.0.
            colorize: 'colorize' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_shape_diameter_function_per_vertex(
        self,
        *,
        rays: int = 64,
        cone_amplitude: float = 90.0,
    ) -> Any:
        """MeshLab's filter 'Compute Shape-Diameter Function'.

        Menus: quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_shape_diameter_function_per_vertex

        Args:
            rays: 'Rays' in scripts. Takes a whole number of at least 0.
            cone_amplitude: 'cone_amplitude' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_shape_diameter_function_per_vertex_gpu(
        self,
        *,
        onprimitive: Literal["On vertices", "On Faces"] = "On vertices",
        numberrays: int = 128,
        depthtexturesize: int = 512,
        peelingiteration: int = 10,
        peelingtolerance: float = 1e-07,
        coneangle: float = 120.0,
        removefalse: bool = True,
        removeoutliers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Shape Diameter Function'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_shape_diameter_function_per_vertex_gpu

        Args:
            onprimitive: 'onPrimitive' in scripts.
            numberrays: 'numberRays' in scripts. Takes a whole number of at least 0.
            depthtexturesize: 'DepthTextureSize' in scripts. Takes a whole number of at least 0.
            peelingiteration: 'peelingIteration' in scripts. Takes a whole number from 0 to 100000.
            peelingtolerance: 'peelingTolerance' in scripts. Takes a number.
            coneangle: 'coneAngle' in scripts. Takes a number.
            removefalse: 'removeFalse' in scripts.
            removeoutliers: 'removeOutliers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_triangle_shape_per_face(
        self,
        *,
        color: bool = True,
    ) -> dict[str, Any] | None:
        """Gives every face its shape quality: 1 for an equilateral triangle, near 0 for slivers, 0 without area.

        The quality is the shortest edge divided by the circumradius, normalised. Colours go from dark violet at 0 to yellow at
        1. Returns these two limits, and the lowest, the highest and the mean value.

        Args:
            color: Also colour the mesh by the scalar, which replaces its colours.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Triangle Shape'.
        """

    def compute_scalar_by_volumetric_obscurance(
        self,
        *,
        rays: int = 64,
        tau: float = 0.1,
    ) -> Any:
        """MeshLab's filter 'Compute Obscurance'.

        Menus: quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_volumetric_obscurance

        Args:
            rays: 'Rays' in scripts. Takes a whole number of at least 0.
            tau: 'TAU' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_by_volumetric_obscurance_gpu(
        self,
        *,
        onprimitive: Literal["On vertices", "On Faces"] = "On vertices",
        numberrays: int = 128,
        depthtexturesize: int = 512,
        peelingiteration: int = 10,
        peelingtolerance: float = 1e-07,
        coneangle: float = 120.0,
        obscuranceexponent: float = 0.1,
    ) -> Any:
        """MeshLab's filter 'Volumetric obscurance'.

        Menus: vertex coloring. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_by_volumetric_obscurance_gpu

        Args:
            onprimitive: 'onPrimitive' in scripts.
            numberrays: 'numberRays' in scripts. Takes a whole number of at least 0.
            depthtexturesize: 'DepthTextureSize' in scripts. Takes a whole number of at least 0.
            peelingiteration: 'peelingIteration' in scripts. Takes a whole number from 0 to 100000.
            peelingtolerance: 'peelingTolerance' in scripts. Takes a number.
            coneangle: 'coneAngle' in scripts. Takes a number.
            obscuranceexponent: 'obscuranceExponent' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_from_camera_per_vertex(
        self,
        *,
        depth: bool = True,
        facing: bool = False,
        clip: bool = False,
        normalize: bool = False,
        map: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Quality from Camera'.

        Menus: quality, raster layer, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_from_camera_per_vertex

        Args:
            depth: 'Depth' in scripts.
            facing: 'Facing' in scripts.
            clip: 'Clip' in scripts.
            normalize: 'normalize' in scripts.
            map: 'map' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_from_raster_coverage_per_face(
        self,
        *,
        normalizequality: bool = False,
    ) -> Any:
        """MeshLab's filter 'Quality from raster coverage (Face)'.

        Menus: quality, texture, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_from_raster_coverage_per_face

        Args:
            normalizequality: 'normalizeQuality' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_from_raster_coverage_per_vertex(
        self,
        *,
        normalizequality: bool = False,
    ) -> Any:
        """MeshLab's filter 'Quality from raster coverage (Vertex)'.

        Menus: quality, texture, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_from_raster_coverage_per_vertex

        Args:
            normalizequality: 'normalizeQuality' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_transfer_face_to_vertex(
        self,
        *,
        areaweight: bool = True,
    ) -> Any:
        """MeshLab's filter 'Transfer Quality: Face to Vertex'.

        Menus: quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_transfer_face_to_vertex

        Args:
            areaweight: 'areaWeight' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_scalar_transfer_vertex_to_face(self) -> Any:
        """MeshLab's filter 'Transfer Quality: Vertex to Face'.

        Menus: quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_scalar_transfer_vertex_to_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_bad_faces(
        self,
        *,
        usear: bool = True,
        aratio: float = 0.02,
        usenf: bool = False,
        nfratio: float = 60.0,
        select_folded_faces: bool = False,
        folded_faces_angle_threshold: float = 160.0,
    ) -> Any:
        """MeshLab's filter "Select 'problematic' faces".

        Menus: selection. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_bad_faces

        Args:
            usear: 'useAR' in scripts.
            aratio: 'ARatio' in scripts. Takes a number from 0.0 to 1.0.
            usenf: 'useNF' in scripts.
            nfratio: 'NFRatio' in scripts. Takes a number from 0.0 to 180.0.
            select_folded_faces: 'select_folded_faces' in scripts.
            folded_faces_angle_threshold: 'folded_faces_angle_threshold' in scripts. Takes a number from 90.0 to 180.0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_angle_with_direction_per_face(
        self,
        *,
        anglelimit: float = 75.0,
        usecamera: bool = False,
        viewpoint: PointLike = (0.0, 0.0, 0.0),
    ) -> Any:
        """MeshLab's filter 'Select Faces by view angle'.

        Menus: selection, range map. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_angle_with_direction_per_face

        Args:
            anglelimit: 'anglelimit' in scripts. Takes a number from 0.0 to 180.0.
            usecamera: 'usecamera' in scripts.
            viewpoint: 'viewpoint' in scripts. Takes three finite numbers.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_color_per_face(
        self,
        *,
        color: ColorLike = (0, 0, 0, 255),
        colorspace: Literal["HSV", "RGB"] = "HSV",
        inclusive: bool = True,
        percentrh: float = 0.2,
        percentgs: float = 0.2,
        percentbv: float = 0.2,
    ) -> Any:
        """MeshLab's filter 'Select Faces by Color'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_color_per_face

        Args:
            color: 'Color' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue, opacity).
            colorspace: 'ColorSpace' in scripts.
            inclusive: 'Inclusive' in scripts.
            percentrh: 'PercentRH' in scripts. Takes a number from 0.0 to 1.0.
            percentgs: 'PercentGS' in scripts. Takes a number from 0.0 to 1.0.
            percentbv: 'PercentBV' in scripts. Takes a number from 0.0 to 1.0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_condition_per_face(
        self,
        *,
        condselect: str = "(fi == 0)",
    ) -> Any:
        """MeshLab's filter 'Conditional Face Selection'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_condition_per_face

        Args:
            condselect: 'condSelect' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_condition_per_vertex(
        self,
        *,
        condselect: str = "(q < 0)",
    ) -> Any:
        """MeshLab's filter 'Conditional Vertex Selection'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_condition_per_vertex

        Args:
            condselect: 'condSelect' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_distance_from_cloud_per_vertex(
        self,
        *,
        reference: int = 0,
        spacings: float = 4.0,
    ) -> dict[str, Any] | None:
        """Selects the parts of a reconstruction without measured points nearby, such as gaps that Screened Poisson closed.

        The spacing at a point is the mean distance to its six nearest neighbours. The unit of distances is the median spacing
        of the cloud or, if larger, two thirds of the median spacing nearby. The selection of vertices is replaced. Let d be the
        given number of spacings. Notes report the share of the area that is selected, the share that stays although it is
        farther than d / 2 from the points, and the share of the points farther than d from the remaining surface. Returns the
        number of selected vertices.

        Args:
            reference: The layer whose vertices are the measured points. Takes the id of a layer (a whole number).
            spacings: Vertices farther from the nearest point than this many spacings of the cloud are selected. Larger keeps
                bridges over wider gaps. Takes a number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Select Vertices Far from a Cloud'.
        """

    def compute_selection_by_edge_length(
        self,
        *,
        threshold: float = ...,
    ) -> Any:
        """MeshLab's filter 'Select Faces with edges longer than...'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_edge_length

        Args:
            threshold: 'Threshold' in scripts. Takes a number. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_grid_per_vertex(
        self,
        *,
        side: LengthLike = "1%",
    ) -> dict[str, Any] | None:
        """Selects all points but the first in each cell of a grid: without them the cloud is thinner, with an even density.

        The remaining points are measured points with all their attributes. The grid has a corner at the origin. The selection
        of vertices is replaced; faces are ignored. Returns the number of selected points.

        Args:
            side: The side of the cells. Larger leaves fewer points. Takes a length such as '1%' (of the bounding box's
                diagonal), '0.5edge' or '0.3' (mesh units) of at least 0.0.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Select Surplus Points'.
        """

    def compute_selection_by_non_manifold_edges_per_face(self) -> Any:
        """MeshLab's filter 'Select non Manifold Edges'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_non_manifold_edges_per_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_non_manifold_per_vertex(self) -> Any:
        """MeshLab's filter 'Select non Manifold Vertices'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_non_manifold_per_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_outlier_probability_per_vertex(
        self,
        *,
        neighbors: int = 20,
        extent: float = 3.0,
        threshold: float = 0.5,
    ) -> dict[str, Any] | None:
        """Selects the vertices that are probably outliers, and gives every vertex its outlier probability.

        LoOP (local outlier probability) compares the distances of a vertex to its neighbours with the distances of these
        neighbours to their own neighbours. So dense and sparse parts of a scan are judged equally. The probability, from 0 to
        1, becomes the vertex scalar. The selection of vertices is replaced, the selection of faces stays. Faces are ignored.
        Returns the number of selected vertices, the largest and the mean probability.

        Args:
            neighbors: The number of neighbours to compare with: more than a stray clump has vertices. More give steadier
                probabilities, blur borders between dense and sparse parts, and take longer. Takes a whole number of at least 1.
            extent: The probability is 0.68 at this many standard deviations beyond the usual distance. Larger gives lower
                probabilities, so fewer vertices are selected. Takes a number of at least 0.1.
            threshold: Vertices with a larger probability are selected. Larger selects fewer, 1 none. Takes a number from 0 to
                1.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [kriegel2009]

        In scripts: 'Select Outliers by Probability (LoOP)'.
        """

    def compute_selection_by_scalar_per_face(
        self,
        *,
        minq: float = ...,
        maxq: float = ...,
        inclusive: bool = True,
    ) -> Any:
        """MeshLab's filter 'Select by Face Quality'.

        Menus: selection, quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_scalar_per_face

        Args:
            minq: 'minQ' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            maxq: 'maxQ' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            inclusive: 'Inclusive' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_scalar_per_vertex(
        self,
        *,
        minq: float = ...,
        maxq: float = ...,
        inclusive: bool = True,
    ) -> Any:
        """MeshLab's filter 'Select by Vertex Quality'.

        Menus: selection, quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_scalar_per_vertex

        Args:
            minq: 'minQ' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            maxq: 'maxQ' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            inclusive: 'Inclusive' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_self_intersections_per_face(self) -> Any:
        """MeshLab's filter 'Select Self Intersecting Faces'.

        Menus: selection, cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_self_intersections_per_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_small_disconnected_components_per_face(
        self,
        *,
        nbfaceratio: float = 0.1,
        nonclosedonly: bool = False,
        nbneighbors: int = 16,
    ) -> Any:
        """MeshLab's filter 'Select small disconnected component'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_small_disconnected_components_per_face

        Args:
            nbfaceratio: 'NbFaceRatio' in scripts. Takes a number.
            nonclosedonly: 'NonClosedOnly' in scripts.
            nbneighbors: 'NbNeighbors' in scripts. Takes a whole number of at least 1.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_by_stray_points_per_vertex(
        self,
        *,
        neighbors: int = 12,
        sparseness: float = 8.0,
        smallest_part: int = 100,
        clouds_only: bool = False,
    ) -> dict[str, Any] | None:
        """Selects the points of a cloud that belong to no surface: single distant points, hazes, and isolated clumps.

        The selection of vertices is replaced. Faces are ignored. Returns the number of selected points.

        Args:
            neighbors: The number of nearest points that measure the local density. More points bridge wider gaps and take
                longer. Takes a whole number of at least 1.
            sparseness: Points whose neighbours are farther than this many times the median distance are usually selected.
                Larger keeps sparser parts of a scan, but also more of the hazes. Takes a number of at least 1.
            smallest_part: Isolated clumps of fewer points than this are selected. For clumps that fill space the limit is three
                times this number. Larger selects larger clumps. Takes a whole number of at least 1.
            clouds_only: Refuse a mesh: deleting the selected vertices would cut holes in it.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Select Stray Points'.
        """

    def compute_selection_by_texture_seams_per_vertex(self) -> Any:
        """MeshLab's filter 'Select Vertex Texture Seams'.

        Menus: selection, texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_by_texture_seams_per_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_crease_per_edge(
        self,
        *,
        angledegneg: float = -45.0,
        angledegpos: float = 45.0,
    ) -> Any:
        """MeshLab's filter 'Select Crease Edges'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_crease_per_edge

        Args:
            angledegneg: 'AngleDegNeg' in scripts. Takes a number.
            angledegpos: 'AngleDegPos' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_from_mesh_border(self) -> Any:
        """MeshLab's filter 'Select Border'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_from_mesh_border

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_of_visible_convex_hull_per_vertex(
        self,
        *,
        radiusthreshold: float = 0.0,
        usecamera: bool = False,
        viewpoint: PointLike = (0.0, 0.0, 0.0),
        convex_hullfp: bool = False,
        triangvp: bool = False,
    ) -> Any:
        """MeshLab's filter 'Select Convex Hull Visible Points'.

        Menus: selection, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_of_visible_convex_hull_per_vertex

        Args:
            radiusthreshold: 'radiusThreshold' in scripts. Takes a number from 0.0 to 7.0.
            usecamera: 'usecamera' in scripts.
            viewpoint: 'viewpoint' in scripts. Takes three finite numbers.
            convex_hullfp: 'convex_hullFP' in scripts.
            triangvp: 'triangVP' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_point_cloud_outliers(
        self,
        *,
        propthreshold: float = 0.8,
        knearest: int = 32,
    ) -> Any:
        """MeshLab's filter 'Select Outliers'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_point_cloud_outliers

        Args:
            propthreshold: 'PropThreshold' in scripts. Takes a number from 0.0 to 1.0.
            knearest: 'KNearest' in scripts. Takes a whole number of at least 1.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_transfer_face_to_vertex(
        self,
        *,
        inclusive: bool = True,
    ) -> Any:
        """MeshLab's filter 'Select Vertices from Faces'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_transfer_face_to_vertex

        Args:
            inclusive: 'Inclusive' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_selection_transfer_vertex_to_face(
        self,
        *,
        inclusive: bool = True,
    ) -> Any:
        """MeshLab's filter 'Select Faces from Vertices'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_selection_transfer_vertex_to_face

        Args:
            inclusive: 'Inclusive' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_by_function_per_vertex(
        self,
        *,
        u: str = "x",
        v: str = "y",
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Per Vertex Texture Function'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_by_function_per_vertex

        Args:
            u: 'u' in scripts. Takes a text.
            v: 'v' in scripts. Takes a text.
            onselected: 'onselected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_by_function_per_wedge(
        self,
        *,
        u0: str = "x0",
        v0: str = "y0",
        u1: str = "x1",
        v1: str = "y1",
        u2: str = "x2",
        v2: str = "y2",
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Per Wedge Texture Function'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_by_function_per_wedge

        Args:
            u0: 'u0' in scripts. Takes a text.
            v0: 'v0' in scripts. Takes a text.
            u1: 'u1' in scripts. Takes a text.
            v1: 'v1' in scripts. Takes a text.
            u2: 'u2' in scripts. Takes a text.
            v2: 'v2' in scripts. Takes a text.
            onselected: 'onselected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_parametrization_and_texture_from_registered_rasters(
        self,
        *,
        texturesize: int = 1024,
        texturename: str = "texture.png",
        colorcorrection: bool = True,
        colorcorrectionfiltersize: int = 1,
        usedistanceweight: bool = True,
        useimgborderweight: bool = True,
        usealphaweight: bool = False,
        cleanisolatedtriangles: bool = True,
        stretchingallowed: bool = False,
        texturegutter: int = 4,
    ) -> Any:
        """MeshLab's filter 'Parameterization + texturing from registered rasters'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_parametrization_and_texture_from_registered_rasters

        Args:
            texturesize: 'textureSize' in scripts. Takes a whole number of at least 0.
            texturename: 'textureName' in scripts. Takes a text.
            colorcorrection: 'colorCorrection' in scripts.
            colorcorrectionfiltersize: 'colorCorrectionFilterSize' in scripts. Takes a whole number of at least 0.
            usedistanceweight: 'useDistanceWeight' in scripts.
            useimgborderweight: 'useImgBorderWeight' in scripts.
            usealphaweight: 'useAlphaWeight' in scripts.
            cleanisolatedtriangles: 'cleanIsolatedTriangles' in scripts.
            stretchingallowed: 'stretchingAllowed' in scripts.
            texturegutter: 'textureGutter' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_parametrization_flat_plane_per_wedge(
        self,
        *,
        projectionplane: Literal["XY", "XZ", "YZ"] = "XY",
        aspectratio: bool = False,
        sidegutter: float = 0.0,
    ) -> Any:
        """MeshLab's filter 'Parametrization: Flat Plane'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_parametrization_flat_plane_per_wedge

        Args:
            projectionplane: 'projectionPlane' in scripts.
            aspectratio: 'aspectRatio' in scripts.
            sidegutter: 'sideGutter' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_parametrization_from_registered_rasters(
        self,
        *,
        usedistanceweight: bool = True,
        useimgborderweight: bool = True,
        usealphaweight: bool = False,
        cleanisolatedtriangles: bool = True,
        stretchingallowed: bool = False,
        texturegutter: int = 4,
    ) -> Any:
        """MeshLab's filter 'Parameterization from registered rasters'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_parametrization_from_registered_rasters

        Args:
            usedistanceweight: 'useDistanceWeight' in scripts.
            useimgborderweight: 'useImgBorderWeight' in scripts.
            usealphaweight: 'useAlphaWeight' in scripts.
            cleanisolatedtriangles: 'cleanIsolatedTriangles' in scripts.
            stretchingallowed: 'stretchingAllowed' in scripts.
            texturegutter: 'textureGutter' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_parametrization_harmonic(
        self,
        *,
        harm_function: int = 1,
    ) -> Any:
        """MeshLab's filter 'Harmonic Parametrization'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_parametrization_harmonic

        Args:
            harm_function: 'harm_function' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_parametrization_least_squares_conformal_maps(self) -> Any:
        """MeshLab's filter 'Least Squares Conformal Maps Parametrization'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_parametrization_least_squares_conformal_maps

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_parametrization_triangle_trivial_per_wedge(
        self,
        *,
        sidedim: int = 0,
        textdim: int = 1024,
        border: int = 2,
        method: Literal["Basic", "Space-optimizing"] = "Space-optimizing",
    ) -> Any:
        """MeshLab's filter 'Parametrization: Trivial Per-Triangle'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_parametrization_triangle_trivial_per_wedge

        Args:
            sidedim: 'sidedim' in scripts. Takes a whole number of at least 0.
            textdim: 'textdim' in scripts. Takes a whole number of at least 0.
            border: 'border' in scripts. Takes a whole number of at least 0.
            method: 'method' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_transfer_vertex_to_wedge(self) -> Any:
        """MeshLab's filter 'Convert PerVertex UV into PerWedge UV'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_transfer_vertex_to_wedge

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texcoord_transfer_wedge_to_vertex(self) -> Any:
        """MeshLab's filter 'Convert PerWedge UV into PerVertex UV'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texcoord_transfer_wedge_to_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def compute_texmap_from_color(
        self,
        *,
        textname: str = "",
        textw: int = 1024,
        texth: int = 1024,
        overwrite: bool = False,
        pullpush: bool = True,
    ) -> Any:
        """MeshLab's filter 'Transfer: Vertex Color to Texture'.

        Menus: texture. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#compute_texmap_from_color

        Args:
            textname: 'textName' in scripts. Takes a text.
            textw: 'textW' in scripts. Takes a whole number of at least 0.
            texth: 'textH' in scripts. Takes a whole number of at least 0.
            overwrite: 'overwrite' in scripts.
            pullpush: 'pullpush' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_annulus(
        self,
        *,
        internalradius: float = 0.5,
        externalradius: float = 1.0,
        sides: int = 32,
    ) -> Any:
        """MeshLab's filter 'Annulus'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_annulus

        Args:
            internalradius: 'internalRadius' in scripts. Takes a number.
            externalradius: 'externalRadius' in scripts. Takes a number.
            sides: 'sides' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_cone(
        self,
        *,
        r0: float = 1.0,
        r1: float = 2.0,
        h: float = 3.0,
        subdiv: int = 36,
    ) -> Any:
        """MeshLab's filter 'Cone'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_cone

        Args:
            r0: 'r0' in scripts. Takes a number.
            r1: 'r1' in scripts. Takes a number.
            h: 'h' in scripts. Takes a number.
            subdiv: 'subdiv' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_cube(
        self,
        *,
        size: float = 1.0,
    ) -> Any:
        """MeshLab's filter 'Box/Cube'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_cube

        Args:
            size: 'size' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_dodecahedron(self) -> Any:
        """MeshLab's filter 'Dodecahedron'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_dodecahedron

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_dodecahedron_sym(self) -> Any:
        """MeshLab's filter 'Dodecahedron (symmetric)'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_dodecahedron_sym

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_fractal_terrain(
        self,
        *,
        steps: int = 8,
        maxheight: float = 0.2,
        scale: float = 1.0,
        seed: float = 2.0,
        algorithm: Literal[
            "fBM (fractal Brownian Motion)",
            "Standard multifractal",
            "Heterogeneous multifractal",
            "Hybrid multifractal terrain",
            "Ridged multifractal terrain",
        ] = "Ridged multifractal terrain",
        octaves: float = 8.0,
        lacunarity: float = 4.0,
        fractalincrement: float = 0.5,
        offset: float = 0.9,
        gain: float = 2.5,
        saveasquality: bool = False,
    ) -> Any:
        """MeshLab's filter 'Fractal Terrain'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_fractal_terrain

        Args:
            steps: 'steps' in scripts. Takes a whole number from 0 to 100000.
            maxheight: 'maxHeight' in scripts. Takes a number from 0.0 to 1.0.
            scale: 'scale' in scripts. Takes a number from 0.0 to 10.0.
            seed: 'seed' in scripts. Takes a number.
            algorithm: 'algorithm' in scripts.
            octaves: 'octaves' in scripts. Takes a number from 1.0 to 20.0.
            lacunarity: 'lacunarity' in scripts. Takes a number.
            fractalincrement: 'fractalIncrement' in scripts. Takes a number.
            offset: 'offset' in scripts. Takes a number.
            gain: 'gain' in scripts. Takes a number.
            saveasquality: 'saveAsQuality' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_grid(
        self,
        *,
        numvertx: int = 10,
        numverty: int = 10,
        absscalex: float = 0.3,
        absscaley: float = 0.3,
        center: bool = False,
    ) -> Any:
        """MeshLab's filter 'Grid Generator'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_grid

        Args:
            numvertx: 'numVertX' in scripts. Takes a whole number of at least 0.
            numverty: 'numVertY' in scripts. Takes a whole number of at least 0.
            absscalex: 'absScaleX' in scripts. Takes a number.
            absscaley: 'absScaleY' in scripts. Takes a number.
            center: 'center' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_icosahedron(self) -> Any:
        """MeshLab's filter 'Icosahedron'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_icosahedron

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_implicit_surface(
        self,
        *,
        voxelsize: float = 0.05,
        minx: float = -1.0,
        miny: float = -1.0,
        minz: float = -1.0,
        maxx: float = 1.0,
        maxy: float = 1.0,
        maxz: float = 1.0,
        expr: str = "x*x+y*y+z*z-0.5",
    ) -> Any:
        """MeshLab's filter 'Implicit Surface'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_implicit_surface

        Args:
            voxelsize: 'voxelSize' in scripts. Takes a number.
            minx: 'minX' in scripts. Takes a number.
            miny: 'minY' in scripts. Takes a number.
            minz: 'minZ' in scripts. Takes a number.
            maxx: 'maxX' in scripts. Takes a number.
            maxy: 'maxY' in scripts. Takes a number.
            maxz: 'maxZ' in scripts. Takes a number.
            expr: 'expr' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_mesh_by_grammar(
        self,
        *,
        grammar: str = ...,
        seed: int = 1,
        sphereres: int = 1,
    ) -> Any:
        """MeshLab's filter 'Structure Synth Mesh Creation'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_mesh_by_grammar

        Args:
            grammar: 'grammar' in scripts. Takes a text.
            seed: 'seed' in scripts. Takes a whole number.
            sphereres: 'sphereres' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_noisy_isosurface(
        self,
        *,
        resolution: int = 64,
    ) -> Any:
        """MeshLab's filter 'Noisy Isosurface'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_noisy_isosurface

        Args:
            resolution: 'Resolution' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_octahedron(self) -> Any:
        """MeshLab's filter 'Octahedron'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_octahedron

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_sphere(
        self,
        *,
        radius: float = 1.0,
        subdiv: int = 3,
    ) -> Any:
        """MeshLab's filter 'Sphere'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_sphere

        Args:
            radius: 'radius' in scripts. Takes a number.
            subdiv: 'subdiv' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_sphere_cap(
        self,
        *,
        angle: float = 60.0,
        subdiv: int = 3,
    ) -> Any:
        """MeshLab's filter 'Sphere Cap'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_sphere_cap

        Args:
            angle: 'angle' in scripts. Takes a number.
            subdiv: 'subdiv' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_sphere_points(
        self,
        *,
        pointnum: int = 100,
        spheregentech: Literal["Montecarlo", "Poisson Sampling", "DiscoBall", "Octahedron", "Fibonacci"] = "Octahedron",
    ) -> Any:
        """MeshLab's filter 'Points on a Sphere'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_sphere_points

        Args:
            pointnum: 'pointNum' in scripts. Takes a whole number of at least 0.
            spheregentech: 'sphereGenTech' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_tetrahedron(self) -> Any:
        """MeshLab's filter 'Tetrahedron'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_tetrahedron

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def create_torus(
        self,
        *,
        hradius: float = 3.0,
        vradius: float = 1.0,
        hsubdiv: int = 24,
        vsubdiv: int = 12,
    ) -> Any:
        """MeshLab's filter 'Torus'.

        Menus: mesh creation. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#create_torus

        Args:
            hradius: 'hRadius' in scripts. Takes a number.
            vradius: 'vRadius' in scripts. Takes a number.
            hsubdiv: 'hSubdiv' in scripts. Takes a whole number of at least 0.
            vsubdiv: 'vSubdiv' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def delete_current_mesh(self) -> Any:
        """MeshLab's filter 'Delete Current Mesh'.

        Menus: layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#delete_current_mesh

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def delete_current_raster(self) -> Any:
        """MeshLab's filter 'Delete Current Raster'.

        Menus: raster layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#delete_current_raster

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def delete_non_active_rasters(self) -> Any:
        """MeshLab's filter 'Delete all Non Selected Rasters'.

        Menus: raster layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#delete_non_active_rasters

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def delete_non_visible_meshes(self) -> Any:
        """MeshLab's filter 'Delete all non visible Mesh Layers'.

        Menus: layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#delete_non_visible_meshes

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def export_mesh_to_sketchfab(
        self,
        *,
        sketchfabkeycode: str = "00000000",
        title: str = "MeshLabModel",
        description: str = "A model generated with meshlab",
        tags: str = "meshlab",
        isprivate: bool = False,
        ispublished: bool = False,
        autorotate: bool = True,
        saveapisetting: bool = False,
    ) -> Any:
        """MeshLab's filter 'Export to Sketchfab'.

        Menus: smoothing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#export_mesh_to_sketchfab

        Args:
            sketchfabkeycode: 'sketchFabKeyCode' in scripts. Takes a text.
            title: 'title' in scripts. Takes a text.
            description: 'description' in scripts. Takes a text.
            tags: 'tags' in scripts. Takes a text.
            isprivate: 'isPrivate' in scripts.
            ispublished: 'isPublished' in scripts.
            autorotate: 'autoRotate' in scripts.
            saveapisetting: 'saveApiSetting' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_alpha_shape(
        self,
        *,
        alpha: LengthLike = "1%",
        filtering: Literal["Alpha Complex", "Alpha Shape"] = "Alpha Complex",
    ) -> Any:
        """MeshLab's filter 'Alpha Complex/Shape'.

        Menus: remeshing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_alpha_shape

        Args:
            alpha: 'alpha' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).
            filtering: 'Filtering' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_alpha_wrap(
        self,
        *,
        alpha: LengthLike = "2%",
        offset: LengthLike = "0.1%",
    ) -> Any:
        """MeshLab's filter 'Alpha Wrap'.

        Menus: remeshing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_alpha_wrap

        Args:
            alpha: 'Alpha' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).
            offset: 'Offset' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_boolean_difference(
        self,
        *,
        first_mesh: int = ...,
        second_mesh: int = ...,
        transfer_face_color: bool = False,
        transfer_face_quality: bool = False,
        transfer_vert_color: bool = False,
        transfer_vert_quality: bool = False,
    ) -> Any:
        """MeshLab's filter 'Mesh Boolean: Difference'.

        Menus: remeshing, layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_boolean_difference

        Args:
            first_mesh: 'first_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            second_mesh: 'second_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            transfer_face_color: 'transfer_face_color' in scripts.
            transfer_face_quality: 'transfer_face_quality' in scripts.
            transfer_vert_color: 'transfer_vert_color' in scripts.
            transfer_vert_quality: 'transfer_vert_quality' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_boolean_intersection(
        self,
        *,
        first_mesh: int = ...,
        second_mesh: int = ...,
        transfer_face_color: bool = False,
        transfer_face_quality: bool = False,
        transfer_vert_color: bool = False,
        transfer_vert_quality: bool = False,
    ) -> Any:
        """MeshLab's filter 'Mesh Boolean: Intersection'.

        Menus: remeshing, layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_boolean_intersection

        Args:
            first_mesh: 'first_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            second_mesh: 'second_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            transfer_face_color: 'transfer_face_color' in scripts.
            transfer_face_quality: 'transfer_face_quality' in scripts.
            transfer_vert_color: 'transfer_vert_color' in scripts.
            transfer_vert_quality: 'transfer_vert_quality' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_boolean_union(
        self,
        *,
        first_mesh: int = ...,
        second_mesh: int = ...,
        transfer_face_color: bool = False,
        transfer_face_quality: bool = False,
        transfer_vert_color: bool = False,
        transfer_vert_quality: bool = False,
    ) -> Any:
        """MeshLab's filter 'Mesh Boolean: Union'.

        Menus: remeshing, layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_boolean_union

        Args:
            first_mesh: 'first_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            second_mesh: 'second_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            transfer_face_color: 'transfer_face_color' in scripts.
            transfer_face_quality: 'transfer_face_quality' in scripts.
            transfer_vert_color: 'transfer_vert_color' in scripts.
            transfer_vert_quality: 'transfer_vert_quality' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_boolean_xor(
        self,
        *,
        first_mesh: int = ...,
        second_mesh: int = ...,
        transfer_face_color: bool = False,
        transfer_face_quality: bool = False,
        transfer_vert_color: bool = False,
        transfer_vert_quality: bool = False,
    ) -> Any:
        """MeshLab's filter 'Mesh Boolean: Symmetric Difference (XOR)'.

        Menus: remeshing, layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_boolean_xor

        Args:
            first_mesh: 'first_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            second_mesh: 'second_mesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            transfer_face_color: 'transfer_face_color' in scripts.
            transfer_face_quality: 'transfer_face_quality' in scripts.
            transfer_vert_color: 'transfer_vert_color' in scripts.
            transfer_vert_quality: 'transfer_vert_quality' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_by_merging_visible_meshes(
        self,
        *,
        mergevisible: bool = True,
        deletelayer: bool = True,
        mergevertices: bool = True,
        alsounreferenced: bool = True,
    ) -> Any:
        """MeshLab's filter 'Flatten Visible Layers'.

        Menus: layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_by_merging_visible_meshes

        Args:
            mergevisible: 'MergeVisible' in scripts.
            deletelayer: 'DeleteLayer' in scripts.
            mergevertices: 'MergeVertices' in scripts.
            alsounreferenced: 'AlsoUnreferenced' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_convex_hull(self) -> Any:
        """MeshLab's filter 'Convex Hull'.

        Menus: remeshing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_convex_hull

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_copy_of_current_mesh(self) -> Any:
        """MeshLab's filter 'Duplicate Current layer'.

        Menus: layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_copy_of_current_mesh

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_cylindrical_unwrapping(
        self,
        *,
        startangle: float = 0.0,
        endangle: float = 360.0,
        radius: float = 0.0,
    ) -> Any:
        """MeshLab's filter 'Geometric Cylindrical Unwrapping'.

        Menus: measure. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_cylindrical_unwrapping

        Args:
            startangle: 'startAngle' in scripts. Takes a number.
            endangle: 'endAngle' in scripts. Takes a number.
            radius: 'radius' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_dust_accumulation_point_cloud(
        self,
        *,
        dust_dir: PointLike = (0.0, 1.0, 0.0),
        nparticles: int = 3,
        slippiness: float = 1.0,
        adhesion: float = 0.2,
        draw_texture: bool = False,
    ) -> Any:
        """MeshLab's filter 'Dust Accumulation'.

        Menus: sampling. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_dust_accumulation_point_cloud

        Args:
            dust_dir: 'dust_dir' in scripts. Takes three finite numbers.
            nparticles: 'nparticles' in scripts. Takes a whole number of at least 0.
            slippiness: 'slippiness' in scripts. Takes a number.
            adhesion: 'adhesion' in scripts. Takes a number.
            draw_texture: 'draw_texture' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_from_selected_faces(
        self,
        *,
        deleteoriginal: bool = True,
    ) -> Any:
        """MeshLab's filter 'Move selected faces to another layer'.

        Menus: layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_from_selected_faces

        Args:
            deleteoriginal: 'DeleteOriginal' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_from_selected_vertices(
        self,
        *,
        deleteoriginal: bool = True,
    ) -> Any:
        """MeshLab's filter 'Move selected vertices to another layer'.

        Menus: layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_from_selected_vertices

        Args:
            deleteoriginal: 'DeleteOriginal' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_iso_parametrization_atlased_mesh(
        self,
        *,
        bordersize: float = 0.1,
    ) -> Any:
        """MeshLab's filter 'Iso Parametrization Build Atlased Mesh'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_iso_parametrization_atlased_mesh

        Args:
            bordersize: 'BorderSize' in scripts. Takes a number from 0.01 to 0.5.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_iso_parametrization_remeshing(
        self,
        *,
        samplingrate: int = 10,
    ) -> Any:
        """MeshLab's filter 'Iso Parametrization Remeshing'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_iso_parametrization_remeshing

        Args:
            samplingrate: 'SamplingRate' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_marching_cubes_apss(
        self,
        *,
        filterscale: float = 2.0,
        projectionaccuracy: float = 0.0001,
        maxprojectioniters: int = 15,
        sphericalparameter: float = 1.0,
        accuratenormal: bool = True,
        resolution: int = 200,
    ) -> Any:
        """MeshLab's filter 'Marching Cubes (APSS)'.

        Menus: remeshing, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_marching_cubes_apss

        Args:
            filterscale: 'FilterScale' in scripts. Takes a number.
            projectionaccuracy: 'ProjectionAccuracy' in scripts. Takes a number.
            maxprojectioniters: 'MaxProjectionIters' in scripts. Takes a whole number from 0 to 100000.
            sphericalparameter: 'SphericalParameter' in scripts. Takes a number.
            accuratenormal: 'AccurateNormal' in scripts.
            resolution: 'Resolution' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_marching_cubes_rimls(
        self,
        *,
        filterscale: float = 2.0,
        projectionaccuracy: float = 0.0001,
        maxprojectioniters: int = 15,
        sigman: float = 0.75,
        maxrefittingiters: int = 3,
        resolution: int = 200,
    ) -> Any:
        """MeshLab's filter 'Marching Cubes (RIMLS)'.

        Menus: remeshing, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_marching_cubes_rimls

        Args:
            filterscale: 'FilterScale' in scripts. Takes a number.
            projectionaccuracy: 'ProjectionAccuracy' in scripts. Takes a number.
            maxprojectioniters: 'MaxProjectionIters' in scripts. Takes a whole number from 0 to 100000.
            sigman: 'SigmaN' in scripts. Takes a number.
            maxrefittingiters: 'MaxRefittingIters' in scripts. Takes a whole number from 0 to 100000.
            resolution: 'Resolution' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_plane_fitting_to_selection(
        self,
        *,
        extent: float = 1.0,
        subdiv: int = 3,
        hasuv: bool = False,
        orientation: Literal[
            "quasi-Straight Fit", "Best Fit", "XZ Parallel", "YZ Parallel", "YX Parallel"
        ] = "quasi-Straight Fit",
    ) -> Any:
        """MeshLab's filter 'Fit a plane to selection'.

        Menus: mesh creation. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_plane_fitting_to_selection

        Args:
            extent: 'extent' in scripts. Takes a number.
            subdiv: 'subdiv' in scripts. Takes a whole number of at least 0.
            hasuv: 'hasuv' in scripts.
            orientation: 'orientation' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_polyline_from_planar_section(
        self,
        *,
        planeaxis: Literal["X Axis", "Y Axis", "Z Axis", "Custom Axis"] = "X Axis",
        customaxis: PointLike = (0.0, 1.0, 0.0),
        planeoffset: float = 0.0,
        relativeto: Literal["Bounding box center", "Bounding box min", "Origin"] = "Origin",
        createsectionsurface: bool = False,
        splitsurfacewithsection: bool = False,
    ) -> Any:
        """MeshLab's filter 'Compute Planar Section'.

        Menus: measure. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_polyline_from_planar_section

        Args:
            planeaxis: 'planeAxis' in scripts.
            customaxis: 'customAxis' in scripts. Takes three finite numbers.
            planeoffset: 'planeOffset' in scripts. Takes a number.
            relativeto: 'relativeTo' in scripts.
            createsectionsurface: 'createSectionSurface' in scripts.
            splitsurfacewithsection: 'splitSurfaceWithSection' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_polyline_from_selected_edges(self) -> Any:
        """MeshLab's filter 'Build a Polyline from Selected Edges'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_polyline_from_selected_edges

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_polyline_from_selection_perimeter(self) -> Any:
        """MeshLab's filter 'Create Selection Perimeter Polyline'.

        Menus: measure. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_polyline_from_selection_perimeter

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_resampled_uniform_mesh(
        self,
        *,
        cellsize: LengthLike = "2%",
        offset: LengthLike = "0",
        mergeclosevert: bool = False,
        discretize: bool = False,
        multisample: bool = False,
        absdist: bool = False,
    ) -> Any:
        """MeshLab's filter 'Uniform Mesh Resampling'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_resampled_uniform_mesh

        Args:
            cellsize: 'CellSize' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            offset: 'Offset' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).
            mergeclosevert: 'mergeCloseVert' in scripts.
            discretize: 'discretize' in scripts.
            multisample: 'multisample' in scripts.
            absdist: 'absDist' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_sampling_clustered_vertex(
        self,
        *,
        threshold: LengthLike = "1%",
        sampling: Literal["Average", "Closest to center"] = "Closest to center",
        selected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Clustered Vertex Sampling'.

        Menus: sampling. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_sampling_clustered_vertex

        Args:
            threshold: 'Threshold' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            sampling: 'Sampling' in scripts.
            selected: 'Selected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_sampling_element(
        self,
        *,
        sampling: Literal["Vertex", "Edge", "Face"] = "Vertex",
        samplenum: int = ...,
    ) -> Any:
        """MeshLab's filter 'Mesh Element Sampling'.

        Menus: sampling. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_sampling_element

        Args:
            sampling: 'Sampling' in scripts.
            samplenum: 'SampleNum' in scripts. Takes a whole number of at least 0. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_sampling_montecarlo(
        self,
        *,
        samplenum: int = ...,
        weighted: bool = False,
        perfacenormal: bool = False,
        radiusvariance: float = 1.0,
        exactnum: bool = True,
        edgesampling: bool = False,
    ) -> Any:
        """MeshLab's filter 'Montecarlo Sampling'.

        Menus: sampling. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_sampling_montecarlo

        Args:
            samplenum: 'SampleNum' in scripts. Takes a whole number of at least 0. By default MeshLab chooses it for the mesh.
            weighted: 'Weighted' in scripts.
            perfacenormal: 'PerFaceNormal' in scripts.
            radiusvariance: 'RadiusVariance' in scripts. Takes a number.
            exactnum: 'ExactNum' in scripts.
            edgesampling: 'EdgeSampling' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_sampling_poisson_disk(
        self,
        *,
        samplenum: int = 1000,
        radius: LengthLike = "0",
        montecarlorate: int = 20,
        savemontecarlo: bool = False,
        approximategeodesicdistance: bool = False,
        subsample: bool = False,
        refineflag: bool = False,
        refinemesh: int = ...,
        bestsampleflag: bool = True,
        bestsamplepool: int = 10,
        exactnumflag: bool = False,
        exactnumtolerance: float = 0.005,
        radiusvariance: float = 1.0,
    ) -> Any:
        """MeshLab's filter 'Poisson-disk Sampling'.

        Menus: sampling. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_sampling_poisson_disk

        Args:
            samplenum: 'SampleNum' in scripts. Takes a whole number of at least 0.
            radius: 'Radius' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).
            montecarlorate: 'MontecarloRate' in scripts. Takes a whole number of at least 0.
            savemontecarlo: 'SaveMontecarlo' in scripts.
            approximategeodesicdistance: 'ApproximateGeodesicDistance' in scripts.
            subsample: 'Subsample' in scripts.
            refineflag: 'RefineFlag' in scripts.
            refinemesh: 'RefineMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            bestsampleflag: 'BestSampleFlag' in scripts.
            bestsamplepool: 'BestSamplePool' in scripts. Takes a whole number of at least 0.
            exactnumflag: 'ExactNumFlag' in scripts.
            exactnumtolerance: 'ExactNumTolerance' in scripts. Takes a number.
            radiusvariance: 'RadiusVariance' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_sampling_regular_recursive(
        self,
        *,
        cellsize: LengthLike = "2%",
        offset: LengthLike = "0",
    ) -> Any:
        """MeshLab's filter 'Regular Recursive Sampling'.

        Menus: sampling. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_sampling_regular_recursive

        Args:
            cellsize: 'CellSize' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            offset: 'Offset' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_sampling_stratified_triangle(
        self,
        *,
        samplenum: int = 100000,
        sampling: Literal[
            "Similar Triangle", "Dual Similar Triangle", "Long Edge Subdiv", "Sample Edges", "Sample NonFaux Edges"
        ] = "Similar Triangle",
        random: bool = False,
    ) -> Any:
        """MeshLab's filter 'Stratified Triangle Sampling'.

        Menus: sampling. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_sampling_stratified_triangle

        Args:
            samplenum: 'SampleNum' in scripts. Takes a whole number of at least 0.
            sampling: 'Sampling' in scripts.
            random: 'Random' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_sampling_texel(
        self,
        *,
        texturew: int = 512,
        textureh: int = 512,
        texturespace: bool = False,
        recovercolor: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Texel Sampling'.

        Menus: sampling. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_sampling_texel

        Args:
            texturew: 'TextureW' in scripts. Takes a whole number of at least 0.
            textureh: 'TextureH' in scripts. Takes a whole number of at least 0.
            texturespace: 'TextureSpace' in scripts.
            recovercolor: 'RecoverColor' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_sampling_volumetric(
        self,
        *,
        samplesurfradius: LengthLike = "0.2%",
        samplevolnum: int = 200000,
        poissonfiltering: bool = True,
        poissonradius: LengthLike = "1%",
    ) -> Any:
        """MeshLab's filter 'Volumetric Sampling'.

        Menus: sampling. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_sampling_volumetric

        Args:
            samplesurfradius: 'sampleSurfRadius' in scripts. Takes a length such as '1%' (of the bounding box's diagonal),
                '0.5edge' or '0.3' (mesh units).
            samplevolnum: 'sampleVolNum' in scripts. Takes a whole number of at least 0.
            poissonfiltering: 'poissonFiltering' in scripts.
            poissonradius: 'poissonRadius' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge'
                or '0.3' (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_sampling_voronoi(
        self,
        *,
        iternum: int = 10,
        samplenum: int = 10,
        radiusvariance: float = 1.0,
        colorstrategy: Literal["None", "Seed Distance", "Border Distance", "Region Area"] = "Seed Distance",
        distancetype: Literal["Euclidean", "Quality Weighted", "Anisotropic"] = "Euclidean",
        preprocessflag: bool = False,
        refinefactor: int = 10,
        perturbprobability: float = 0.0,
        perturbamount: float = 0.001,
        randomseed: int = 0,
        relaxtype: Literal["Geodesic", "Squared Distance", "Restricted"] = "Squared Distance",
    ) -> Any:
        """MeshLab's filter 'Voronoi Sampling'.

        Menus: sampling. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_sampling_voronoi

        Args:
            iternum: 'iterNum' in scripts. Takes a whole number from 0 to 100000.
            samplenum: 'sampleNum' in scripts. Takes a whole number of at least 0.
            radiusvariance: 'radiusVariance' in scripts. Takes a number.
            colorstrategy: 'colorStrategy' in scripts.
            distancetype: 'distanceType' in scripts.
            preprocessflag: 'preprocessFlag' in scripts.
            refinefactor: 'refineFactor' in scripts. Takes a whole number of at least 0.
            perturbprobability: 'perturbProbability' in scripts. Takes a number.
            perturbamount: 'perturbAmount' in scripts. Takes a number.
            randomseed: 'randomSeed' in scripts. Takes a whole number.
            relaxtype: 'relaxType' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_simplified_point_cloud(
        self,
        *,
        samplenum: int = 1000,
        radius: LengthLike = "0",
        bestsampleflag: bool = True,
        bestsamplepool: int = 10,
        exactnumflag: bool = False,
        exactnumtolerance: float = 0.005,
    ) -> Any:
        """MeshLab's filter 'Point Cloud Simplification'.

        Menus: sampling, point set. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_simplified_point_cloud

        Args:
            samplenum: 'SampleNum' in scripts. Takes a whole number of at least 0.
            radius: 'Radius' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh
                units).
            bestsampleflag: 'BestSampleFlag' in scripts.
            bestsamplepool: 'BestSamplePool' in scripts. Takes a whole number of at least 0.
            exactnumflag: 'ExactNumFlag' in scripts.
            exactnumtolerance: 'ExactNumTolerance' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_solid_wireframe(
        self,
        *,
        edgecylflag: bool = True,
        edgecylradius: LengthLike = "1%",
        vertcylflag: bool = False,
        vertcylradius: LengthLike = "1%",
        vertsphflag: bool = True,
        vertsphradius: LengthLike = "1%",
        faceextflag: bool = True,
        faceextheight: LengthLike = "0.5%",
        faceextinset: LengthLike = "0.5%",
        edgefauxflag: bool = True,
        cylindersidenum: int = 16,
    ) -> Any:
        """MeshLab's filter 'Create Solid Wireframe'.

        Menus: remeshing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_solid_wireframe

        Args:
            edgecylflag: 'edgeCylFlag' in scripts.
            edgecylradius: 'edgeCylRadius' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge'
                or '0.3' (mesh units).
            vertcylflag: 'vertCylFlag' in scripts.
            vertcylradius: 'vertCylRadius' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge'
                or '0.3' (mesh units).
            vertsphflag: 'vertSphFlag' in scripts.
            vertsphradius: 'vertSphRadius' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge'
                or '0.3' (mesh units).
            faceextflag: 'faceExtFlag' in scripts.
            faceextheight: 'faceExtHeight' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge'
                or '0.3' (mesh units).
            faceextinset: 'faceExtInset' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or
                '0.3' (mesh units).
            edgefauxflag: 'edgeFauxFlag' in scripts.
            cylindersidenum: 'cylinderSideNum' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_splitting_by_connected_components(
        self,
        *,
        delete_source_mesh: bool = False,
    ) -> Any:
        """MeshLab's filter 'Split in Connected Components'.

        Menus: layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_splitting_by_connected_components

        Args:
            delete_source_mesh: 'delete_source_mesh' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_surface_reconstruction_ball_pivoting(
        self,
        *,
        ballradius: LengthLike = "0",
        clustering: float = 20.0,
        creasethr: float = 90.0,
        deletefaces: bool = False,
    ) -> Any:
        """MeshLab's filter 'Surface Reconstruction: Ball Pivoting'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_surface_reconstruction_ball_pivoting

        Args:
            ballradius: 'BallRadius' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or
                '0.3' (mesh units).
            clustering: 'Clustering' in scripts. Takes a number.
            creasethr: 'CreaseThr' in scripts. Takes a number.
            deletefaces: 'DeleteFaces' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_surface_reconstruction_screened_poisson(
        self,
        *,
        visiblelayer: bool = False,
        depth: int = 8,
        fulldepth: int = 5,
        cgdepth: int = 0,
        scale: float = 1.1,
        samplespernode: float = 1.5,
        pointweight: float = 4.0,
        iters: int = 8,
        confidence: bool = False,
        preclean: bool = False,
        threads: int = ...,
    ) -> Any:
        """MeshLab's filter 'Surface Reconstruction: Screened Poisson'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_surface_reconstruction_screened_poisson

        Args:
            visiblelayer: 'visibleLayer' in scripts.
            depth: 'depth' in scripts. Takes a whole number of at least 0.
            fulldepth: 'fullDepth' in scripts. Takes a whole number of at least 0.
            cgdepth: 'cgDepth' in scripts. Takes a whole number of at least 0.
            scale: 'scale' in scripts. Takes a number.
            samplespernode: 'samplesPerNode' in scripts. Takes a number.
            pointweight: 'pointWeight' in scripts. Takes a number.
            iters: 'iters' in scripts. Takes a whole number from 0 to 100000.
            confidence: 'confidence' in scripts.
            preclean: 'preClean' in scripts.
            threads: 'threads' in scripts. Takes a whole number. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_surface_reconstruction_vcg(
        self,
        *,
        voxsize: LengthLike = "1%",
        subdiv: int = 1,
        geodesic: float = 2.0,
        openresult: bool = True,
        smoothnum: int = 1,
        widenum: int = 3,
        mergecolor: bool = False,
        simplification: bool = False,
        normalsmooth: int = 3,
    ) -> Any:
        """MeshLab's filter 'Surface Reconstruction: VCG'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_surface_reconstruction_vcg

        Args:
            voxsize: 'voxSize' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            subdiv: 'subdiv' in scripts. Takes a whole number of at least 0.
            geodesic: 'geodesic' in scripts. Takes a number.
            openresult: 'openResult' in scripts.
            smoothnum: 'smoothNum' in scripts. Takes a whole number from 0 to 100000.
            widenum: 'wideNum' in scripts. Takes a whole number of at least 0.
            mergecolor: 'mergeColor' in scripts.
            simplification: 'simplification' in scripts.
            normalsmooth: 'normalSmooth' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_voronoi_atlas_parametrization(
        self,
        *,
        regionnum: int = 10,
        overlapflag: bool = False,
    ) -> Any:
        """MeshLab's filter 'Parametrization: Voronoi Atlas'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_voronoi_atlas_parametrization

        Args:
            regionnum: 'regionNum' in scripts. Takes a whole number of at least 0.
            overlapflag: 'overlapFlag' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_voronoi_filtering(
        self,
        *,
        threshold: float = 10.0,
    ) -> Any:
        """MeshLab's filter 'Voronoi Filtering'.

        Menus: remeshing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_voronoi_filtering

        Args:
            threshold: 'threshold' in scripts. Takes a number from 0.0 to 2000.0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def generate_voronoi_scaffolding(
        self,
        *,
        samplesurfradius: LengthLike = "1%",
        samplevolnum: int = 100000,
        voxelres: int = 50,
        isothr: float = 1.0,
        smoothstep: int = 3,
        relaxstep: int = 5,
        surfflag: bool = True,
        elemtype: Literal["Seed", "Edge", "Face"] = "Edge",
    ) -> Any:
        """MeshLab's filter 'Voronoi Scaffolding'.

        Menus: sampling. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#generate_voronoi_scaffolding

        Args:
            samplesurfradius: 'sampleSurfRadius' in scripts. Takes a length such as '1%' (of the bounding box's diagonal),
                '0.5edge' or '0.3' (mesh units).
            samplevolnum: 'sampleVolNum' in scripts. Takes a whole number of at least 0.
            voxelres: 'voxelRes' in scripts. Takes a whole number of at least 0.
            isothr: 'isoThr' in scripts. Takes a number.
            smoothstep: 'smoothStep' in scripts. Takes a whole number from 0 to 100000.
            relaxstep: 'relaxStep' in scripts. Takes a whole number from 0 to 100000.
            surfflag: 'surfFlag' in scripts.
            elemtype: 'elemType' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_area_and_perimeter_of_selection(self) -> dict[str, Any]:
        """MeshLab's filter 'Compute Area/Perimeter of selection'.

        Menus: measure. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_area_and_perimeter_of_selection

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_depth_complexity(
        self,
        *,
        onprimitive: Literal["On vertices", "On Faces"] = "On vertices",
        numberrays: int = 128,
        depthtexturesize: int = 512,
        peelingiteration: int = 10,
        peelingtolerance: float = 1e-07,
    ) -> Any:
        """MeshLab's filter 'Depth complexity'.

        Menus: vertex coloring. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_depth_complexity

        Args:
            onprimitive: 'onPrimitive' in scripts.
            numberrays: 'numberRays' in scripts. Takes a whole number of at least 0.
            depthtexturesize: 'DepthTextureSize' in scripts. Takes a whole number of at least 0.
            peelingiteration: 'peelingIteration' in scripts. Takes a whole number from 0 to 100000.
            peelingtolerance: 'peelingTolerance' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_geometric_measures(self) -> dict[str, Any]:
        """MeshLab's filter 'Compute Geometric Measures'.

        Menus: measure. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_geometric_measures

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_hausdorff_distance(
        self,
        *,
        sampledmesh: int = ...,
        targetmesh: int = ...,
        savesample: bool = False,
        samplevert: bool = True,
        sampleedge: bool = False,
        samplefauxedge: bool = False,
        sampleface: bool = False,
        samplenum: int = ...,
        maxdist: LengthLike = "50%",
    ) -> Any:
        """MeshLab's filter 'Hausdorff Distance'.

        Menus: sampling. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_hausdorff_distance

        Args:
            sampledmesh: 'SampledMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for
                the mesh.
            targetmesh: 'TargetMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            savesample: 'SaveSample' in scripts.
            samplevert: 'SampleVert' in scripts.
            sampleedge: 'SampleEdge' in scripts.
            samplefauxedge: 'SampleFauxEdge' in scripts.
            sampleface: 'SampleFace' in scripts.
            samplenum: 'SampleNum' in scripts. Takes a whole number of at least 0. By default MeshLab chooses it for the mesh.
            maxdist: 'MaxDist' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_overlapping_meshes_graph(
        self,
        *,
        ogsize: int = 50000,
    ) -> dict[str, Any]:
        """MeshLab's filter 'Overlapping Meshes'.

        Menus: measure. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_overlapping_meshes_graph

        Args:
            ogsize: 'OGSize' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_scalar_histogram_per_face(
        self,
        *,
        histmin: float = ...,
        histmax: float = ...,
        areaweighted: bool = False,
        binnum: int = 20,
    ) -> dict[str, Any]:
        """MeshLab's filter 'Per Face Quality Histogram'.

        Menus: measure. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_scalar_histogram_per_face

        Args:
            histmin: 'HistMin' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            histmax: 'HistMax' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            areaweighted: 'areaWeighted' in scripts.
            binnum: 'binNum' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_scalar_histogram_per_vertex(
        self,
        *,
        histmin: float = ...,
        histmax: float = ...,
        areaweighted: bool = False,
        binnum: int = 20,
    ) -> dict[str, Any]:
        """MeshLab's filter 'Per Vertex Quality Histogram'.

        Menus: measure. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_scalar_histogram_per_vertex

        Args:
            histmin: 'HistMin' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            histmax: 'HistMax' in scripts. Takes a number. By default MeshLab chooses it for the mesh.
            areaweighted: 'areaWeighted' in scripts.
            binnum: 'binNum' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_scalar_statistics_per_face(self) -> dict[str, Any]:
        """MeshLab's filter 'Per Face Quality Stat'.

        Menus: measure. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_scalar_statistics_per_face

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_scalar_statistics_per_vertex(self) -> dict[str, Any]:
        """MeshLab's filter 'Per Vertex Quality Stat'.

        Menus: measure. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_scalar_statistics_per_vertex

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_surface_measures(self) -> dict[str, Any]:
        """Measures the counts, topology, size, roughness and triangle quality of the mesh.

        Counts vertices, unreferenced vertices, faces, degenerate and folded faces, edges, border edges, non-manifold edges and
        vertices, and components; reports whether the surface is closed and oriented, its genus and Euler characteristic;
        measures diagonal, area, volume (if closed and oriented), mean edge (also of polylines), mean spacing of clouds (to the
        nearest point), roughness (mean angle in degrees between normals of adjacent faces) and mean triangle quality (1 for
        equilateral triangles).

        Returns:
            What the filter reports, by name; None if it reports nothing.

        In scripts: 'Surface Measures'.
        """

    def get_surface_spectrum(
        self,
        *,
        modes: int = 50,
        operator: Literal["auto", "cotangent", "robust"] = "auto",
    ) -> dict[str, Any]:
        """Measures the energy of the shape by frequency, which shows where the shape ends and the noise begins.

        The energy of a frequency is the contribution of its waves to the mean squared distance of the surface from the
        centroids of its components, in squared mesh units; a frequency is 2 pi over a wavelength, in radians per mesh unit.
        Returns frequencies and energies of the lowest modes; bounds and energies of bands of a third of an octave, up to the
        finest waves of the mesh; and the total energy, the area, the diagonal and the mean edge.

        Args:
            modes: The number of modes to list, from the lowest. More reach higher frequencies and take longer; bands need no
                modes. Takes a whole number from 0 to 100000.
            operator: 'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same operator for slivers and
                non-manifold meshes; 'auto' takes 'robust' if it is needed.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [vallet2008], [golub1969]

        In scripts: 'Surface Spectrum'.
        """

    def get_topological_measures(self) -> dict[str, Any]:
        """MeshLab's filter 'Compute Topological Measures'.

        Menus: measure. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_topological_measures

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def get_topological_measures_from_quad_mesh(self) -> dict[str, Any]:
        """MeshLab's filter 'Compute Topological Measures for Quad Meshes'.

        Menus: measure. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#get_topological_measures_from_quad_mesh

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def load_active_raster_cameras(
        self,
        *,
        importfile: str = "",
    ) -> Any:
        """MeshLab's filter 'Import cameras for active rasters from file'.

        Menus: raster layer, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#load_active_raster_cameras

        Args:
            importfile: 'ImportFile' in scripts. Takes the path of a file to read.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_bridge_rims_by_fairing(
        self,
        *,
        energy: Literal["membrane", "thin_plate", "minimum_variation"] = "thin_plate",
        selected: bool = False,
    ) -> dict[str, Any] | None:
        """Joins two parts of a mesh by a smooth neck between two rims that face each other.

        A rim is a loop of border edges. The neck is a band of triangles, as dense as the rims, between the two nearest rims of
        different parts; its inside is faired. Old vertices stay. The new elements are selected. Merge parts in different layers
        first (Flatten Visible Layers). Returns the numbers of new vertices and triangles, and of the edges of each rim.

        Args:
            energy: 'membrane' is like a soap film, with a crease at the boundary; 'thin_plate' bends least and continues the
                surrounding tangent planes; 'minimum_variation' continues the curvatures too, so that round shapes stay round.
            selected: Join the two nearest selected rims, which may belong to the same part; a rim is selected if all of its
                vertices are.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [fuchs1977], [botsch2004]

        In scripts: 'Bridge Rims by Fairing'.
        """

    def meshing_close_holes(
        self,
        *,
        maxholesize: int = 30,
        selected: bool = ...,
        newfaceselected: bool = True,
        selfintersection: bool = True,
        refinehole: bool = False,
        refineholeedgelen: LengthLike = "3%",
    ) -> Any:
        """MeshLab's filter 'Close Holes'.

        Menus: remeshing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_close_holes

        Args:
            maxholesize: 'MaxHoleSize' in scripts. Takes a whole number of at least 0.
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.
            newfaceselected: 'NewFaceSelected' in scripts.
            selfintersection: 'SelfIntersection' in scripts.
            refinehole: 'RefineHole' in scripts.
            refineholeedgelen: 'RefineHoleEdgeLen' in scripts. Takes a length such as '1%' (of the bounding box's diagonal),
                '0.5edge' or '0.3' (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
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
        """Closes holes with triangles that are as dense as those around, and continue the surface smoothly across the rim.

        Old elements stay as they are, textures too. New vertices and faces come last and become the selection. They continue
        colours and scalars from the rim, and a new face shows a nearby place of the texture with a similar colour. Returns the
        numbers of closed holes, new vertices, new faces, holes with joined islands and holes filled with a lower energy than
        asked for, the number of open rims by reason, and the number of edges of each closed and each open rim; notes name the
        largest rims.

        Args:
            max_edges: The largest number of edges in the rim of a hole. Larger closes larger holes; a hole of 10,000 edges
                takes half a gigabyte of memory. Outer borders of open sheets stay open: most rims with a total geodesic
                curvature above 1.5 pi (a flat disc has 2 pi); and, unless selected, most that span more than a third of the
                area of their sheet. Takes a whole number from 3 to 10000.
            energy: How the new vertices are placed: 'membrane' spans a hole like a soap film, with a crease at its rim;
                'thin_plate' continues the tangent planes at the rim; 'minimum_variation' continues the curvatures too, and
                follows noise there; 'none' leaves them on the flat triangles that first close the hole. Degenerate triangles
                and spikes may need a lower energy (earlier in this list, or 'none'); notes say so.
            refine: Split the new faces until they are as dense as those around the hole. Otherwise there are no new vertices,
                and nothing is faired.
            rounds: How often the new faces are refined and faired. More rounds let a filling bulge further if the mesh bulges
                there. Takes a whole number from 1 to 100.
            islands: What to do with loose pieces of surface in a hole: 'join' connects them to the filling, and leaves the hole
                open if that fails; 'leave' fills the hole as if they were not there.
            selected: Close only holes whose rim has a selected vertex, or a vertex of a selected face.
            mark: How new faces are marked in a saved file: 'scalar' replaces the face scalars by the number of the hole, from
                1, and by 0 on old faces; 'color' paints new faces orange, and old faces white if they have no colours; 'none'
                does neither.

        Returns:
            What the filter reports, by name; None if it reports nothing.

        References:
            [liepa2003]

        In scripts: 'Close Holes by Fairing'.
        """

    def meshing_cut_along_crease_edges(
        self,
        *,
        angledeg: float = 90.0,
    ) -> Any:
        """MeshLab's filter 'Cut mesh along crease edges'.

        Menus: remeshing, normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_cut_along_crease_edges

        Args:
            angledeg: 'angleDeg' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_decimation_clustering(
        self,
        *,
        threshold: LengthLike = "1%",
    ) -> Any:
        """MeshLab's filter 'Simplification: Clustering Decimation'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_decimation_clustering

        Args:
            threshold: 'Threshold' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_decimation_edge_collapse_for_marching_cube_meshes(self) -> Any:
        """MeshLab's filter 'Simplification: Edge Collapse for Marching Cube meshes'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_decimation_edge_collapse_for_marching_cube_meshes

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_decimation_quadric_edge_collapse(
        self,
        *,
        targetfacenum: int = ...,
        targetperc: float = 0.0,
        qualitythr: float = 0.3,
        preserveboundary: bool = False,
        boundaryweight: float = 1.0,
        preservenormal: bool = False,
        preservetopology: bool = False,
        optimalplacement: bool = True,
        planarquadric: bool = False,
        planarweight: float = 0.001,
        qualityweight: bool = False,
        autoclean: bool = True,
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Simplification: Quadric Edge Collapse Decimation'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_decimation_quadric_edge_collapse

        Args:
            targetfacenum: 'TargetFaceNum' in scripts. Takes a whole number of at least 0. By default MeshLab chooses it for the
                mesh.
            targetperc: 'TargetPerc' in scripts. Takes a number.
            qualitythr: 'QualityThr' in scripts. Takes a number.
            preserveboundary: 'PreserveBoundary' in scripts.
            boundaryweight: 'BoundaryWeight' in scripts. Takes a number.
            preservenormal: 'PreserveNormal' in scripts.
            preservetopology: 'PreserveTopology' in scripts.
            optimalplacement: 'OptimalPlacement' in scripts.
            planarquadric: 'PlanarQuadric' in scripts.
            planarweight: 'PlanarWeight' in scripts. Takes a number.
            qualityweight: 'QualityWeight' in scripts.
            autoclean: 'AutoClean' in scripts.
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_decimation_quadric_edge_collapse_with_texture(
        self,
        *,
        targetfacenum: int = ...,
        targetperc: float = 0.0,
        qualitythr: float = 0.3,
        extratcoordw: float = 1.0,
        preserveboundary: bool = False,
        boundaryweight: float = 1.0,
        optimalplacement: bool = True,
        preservenormal: bool = False,
        planarquadric: bool = False,
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Simplification: Quadric Edge Collapse Decimation (with texture)'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_decimation_quadric_edge_collapse_with_texture

        Args:
            targetfacenum: 'TargetFaceNum' in scripts. Takes a whole number of at least 0. By default MeshLab chooses it for the
                mesh.
            targetperc: 'TargetPerc' in scripts. Takes a number.
            qualitythr: 'QualityThr' in scripts. Takes a number.
            extratcoordw: 'Extratcoordw' in scripts. Takes a number.
            preserveboundary: 'PreserveBoundary' in scripts.
            boundaryweight: 'BoundaryWeight' in scripts. Takes a number.
            optimalplacement: 'OptimalPlacement' in scripts.
            preservenormal: 'PreserveNormal' in scripts.
            planarquadric: 'PlanarQuadric' in scripts.
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_edge_flip_by_curvature_optimization(
        self,
        *,
        selection: bool = ...,
        pthreshold: float = 1.0,
        curvtype: Literal["mean", "norm squared", "absolute"] = "mean",
    ) -> Any:
        """MeshLab's filter 'Curvature flipping optimization'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_edge_flip_by_curvature_optimization

        Args:
            selection: 'selection' in scripts. By default MeshLab chooses it for the mesh.
            pthreshold: 'pthreshold' in scripts. Takes a number.
            curvtype: 'curvtype' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_edge_flip_by_planar_optimization(
        self,
        *,
        selection: bool = ...,
        pthreshold: float = 1.0,
        planartype: Literal["area/max side", "inradius/circumradius", "mean ratio", "delaunay", "topology"] = "area/max side",
        iterations: int = 1,
    ) -> Any:
        """MeshLab's filter 'Planar flipping optimization'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_edge_flip_by_planar_optimization

        Args:
            selection: 'selection' in scripts. By default MeshLab chooses it for the mesh.
            pthreshold: 'pthreshold' in scripts. Takes a number.
            planartype: 'planartype' in scripts.
            iterations: 'iterations' in scripts. Takes a whole number from 0 to 100000.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_invert_face_orientation(
        self,
        *,
        forceflip: bool = True,
        onlyselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Invert Faces Orientation'.

        Menus: normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_invert_face_orientation

        Args:
            forceflip: 'forceFlip' in scripts.
            onlyselected: 'onlySelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_isotropic_explicit_remeshing(
        self,
        *,
        iterations: int = 10,
        adaptive: bool = False,
        selectedonly: bool = False,
        targetlen: LengthLike = "1%",
        featuredeg: float = 30.0,
        checksurfdist: bool = True,
        maxsurfdist: LengthLike = "1%",
        splitflag: bool = True,
        collapseflag: bool = True,
        swapflag: bool = True,
        smoothflag: bool = True,
        reprojectflag: bool = True,
    ) -> Any:
        """MeshLab's filter 'Remeshing: Isotropic Explicit Remeshing'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_isotropic_explicit_remeshing

        Args:
            iterations: 'Iterations' in scripts. Takes a whole number from 0 to 100000.
            adaptive: 'Adaptive' in scripts.
            selectedonly: 'SelectedOnly' in scripts.
            targetlen: 'TargetLen' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            featuredeg: 'FeatureDeg' in scripts. Takes a number.
            checksurfdist: 'CheckSurfDist' in scripts.
            maxsurfdist: 'MaxSurfDist' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or
                '0.3' (mesh units).
            splitflag: 'SplitFlag' in scripts.
            collapseflag: 'CollapseFlag' in scripts.
            swapflag: 'SwapFlag' in scripts.
            smoothflag: 'SmoothFlag' in scripts.
            reprojectflag: 'ReprojectFlag' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_merge_close_vertices(
        self,
        *,
        threshold: LengthLike = "0.01%",
    ) -> Any:
        """MeshLab's filter 'Merge Close Vertices'.

        Menus: cleaning. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_merge_close_vertices

        Args:
            threshold: 'Threshold' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_poly_to_tri(self) -> Any:
        """MeshLab's filter 'Turn into a Pure-Triangular mesh'.

        Menus: remeshing, polygonal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_poly_to_tri

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_re_orient_faces_by_geometry(
        self,
        *,
        rays: int = 64,
        parity_sampling: bool = False,
    ) -> Any:
        """MeshLab's filter 'Reorient face normals by geometry'.

        Menus: quality. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_re_orient_faces_by_geometry

        Args:
            rays: 'Rays' in scripts. Takes a whole number of at least 0.
            parity_sampling: 'parity_sampling' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_re_orient_faces_coherently(self) -> Any:
        """MeshLab's filter 'Re-Orient all faces coherently'.

        Menus: normal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_re_orient_faces_coherently

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_refine_by_function(
        self,
        *,
        condselect: str = "(q0 >= 0 && q1 >= 0)",
        x: str = "(x0+x1)/2",
        y: str = "(y0+y1)/2",
        z: str = "(z0+z1)/2",
    ) -> Any:
        """MeshLab's filter 'Refine User-Defined'.

        Menus: remeshing. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_refine_by_function

        Args:
            condselect: 'condSelect' in scripts. Takes a text.
            x: 'x' in scripts. Takes a text.
            y: 'y' in scripts. Takes a text.
            z: 'z' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_all_faces(
        self,
        *,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Delete ALL Faces'.

        Menus: selection. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_all_faces

        Args:
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_connected_component_by_diameter(
        self,
        *,
        mincomponentdiag: LengthLike = "10%",
        removeunref: bool = True,
    ) -> Any:
        """MeshLab's filter 'Remove Isolated pieces (wrt Diameter)'.

        Menus: cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_connected_component_by_diameter

        Args:
            mincomponentdiag: 'MinComponentDiag' in scripts. Takes a length such as '1%' (of the bounding box's diagonal),
                '0.5edge' or '0.3' (mesh units).
            removeunref: 'removeUnref' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_connected_component_by_face_number(
        self,
        *,
        mincomponentsize: int = 25,
        removeunref: bool = True,
    ) -> Any:
        """MeshLab's filter 'Remove Isolated pieces (wrt Face Num.)'.

        Menus: cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_connected_component_by_face_number

        Args:
            mincomponentsize: 'MinComponentSize' in scripts. Takes a whole number of at least 0.
            removeunref: 'removeUnref' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_duplicate_faces(self) -> Any:
        """MeshLab's filter 'Remove Duplicate Faces'.

        Menus: cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_duplicate_faces

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_duplicate_vertices(self) -> Any:
        """MeshLab's filter 'Remove Duplicate Vertices'.

        Menus: cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_duplicate_vertices

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_folded_faces(self) -> Any:
        """MeshLab's filter 'Remove Isolated Folded Faces by Edge Flip'.

        Menus: cleaning. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_folded_faces

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_null_faces(self) -> Any:
        """MeshLab's filter 'Remove Zero Area Faces'.

        Menus: cleaning. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_null_faces

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_selected_faces(self) -> Any:
        """MeshLab's filter 'Delete Selected Faces'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_selected_faces

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_selected_vertices(self) -> Any:
        """MeshLab's filter 'Delete Selected Vertices'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_selected_vertices

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_selected_vertices_and_faces(self) -> Any:
        """MeshLab's filter 'Delete Selected Faces and Vertices'.

        Menus: selection. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_selected_vertices_and_faces

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_t_vertices(
        self,
        *,
        method: Literal["Edge Collapse", "Edge Flip"] = "Edge Collapse",
        threshold: float = 40.0,
        repeat: bool = True,
    ) -> Any:
        """MeshLab's filter 'Remove T-Vertices'.

        Menus: cleaning. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_t_vertices

        Args:
            method: 'method' in scripts.
            threshold: 'Threshold' in scripts. Takes a number.
            repeat: 'Repeat' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_unreferenced_vertices(self) -> Any:
        """MeshLab's filter 'Remove Unreferenced Vertices'.

        Menus: cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_unreferenced_vertices

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_remove_vertices_by_scalar(
        self,
        *,
        maxqualitythr: LengthLike = "1",
    ) -> Any:
        """MeshLab's filter 'Remove Vertices wrt Quality'.

        Menus: cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_remove_vertices_by_scalar

        Args:
            maxqualitythr: 'MaxQualityThr' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge'
                or '0.3' (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_repair_non_manifold_edges(
        self,
        *,
        method: Literal["Remove Faces", "Split Vertices"] = "Remove Faces",
    ) -> Any:
        """MeshLab's filter 'Repair non Manifold Edges'.

        Menus: cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_repair_non_manifold_edges

        Args:
            method: 'method' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_repair_non_manifold_vertices(
        self,
        *,
        vertdispratio: float = 0.0,
    ) -> Any:
        """MeshLab's filter 'Repair non Manifold Vertices by splitting'.

        Menus: cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_repair_non_manifold_vertices

        Args:
            vertdispratio: 'VertDispRatio' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_snap_mismatched_borders(
        self,
        *,
        edgedistratio: float = 0.01,
        unifyvertices: bool = True,
    ) -> Any:
        """MeshLab's filter 'Snap Mismatched Borders'.

        Menus: cleaning. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_snap_mismatched_borders

        Args:
            edgedistratio: 'EdgeDistRatio' in scripts. Takes a number.
            unifyvertices: 'UnifyVertices' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_surface_subdivision_butterfly(
        self,
        *,
        iterations: int = 3,
        threshold: LengthLike = "1%",
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Subdivision Surfaces: Butterfly Subdivision'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_surface_subdivision_butterfly

        Args:
            iterations: 'Iterations' in scripts. Takes a whole number from 0 to 16.
            threshold: 'Threshold' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_surface_subdivision_catmull_clark(
        self,
        *,
        iterations: int = 2,
    ) -> Any:
        """MeshLab's filter 'Subdivision Surfaces: Catmull-Clark'.

        Menus: remeshing, polygonal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_surface_subdivision_catmull_clark

        Args:
            iterations: 'Iterations' in scripts. Takes a whole number from 0 to 16.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_surface_subdivision_doo_sabin(
        self,
        *,
        iterations: int = 2,
    ) -> Any:
        """MeshLab's filter 'Subdivision Surfaces: Doo Sabin'.

        Menus: remeshing, polygonal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_surface_subdivision_doo_sabin

        Args:
            iterations: 'Iterations' in scripts. Takes a whole number from 0 to 16.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_surface_subdivision_loop(
        self,
        *,
        loopweight: Literal["Loop", "Enhance regularity", "Enhance continuity"] = "Loop",
        iterations: int = 3,
        threshold: LengthLike = "1%",
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Subdivision Surfaces: Loop'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_surface_subdivision_loop

        Args:
            loopweight: 'LoopWeight' in scripts.
            iterations: 'Iterations' in scripts. Takes a whole number from 0 to 16.
            threshold: 'Threshold' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_surface_subdivision_ls3_loop(
        self,
        *,
        loopweight: Literal["Loop", "Enhance regularity", "Enhance continuity"] = "Loop",
        iterations: int = 3,
        threshold: LengthLike = "1%",
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Subdivision Surfaces: LS3 Loop'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_surface_subdivision_ls3_loop

        Args:
            loopweight: 'LoopWeight' in scripts.
            iterations: 'Iterations' in scripts. Takes a whole number from 0 to 16.
            threshold: 'Threshold' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_surface_subdivision_midpoint(
        self,
        *,
        iterations: int = 3,
        threshold: LengthLike = "1%",
        selected: bool = ...,
    ) -> Any:
        """MeshLab's filter 'Subdivision Surfaces: Midpoint'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_surface_subdivision_midpoint

        Args:
            iterations: 'Iterations' in scripts. Takes a whole number from 0 to 16.
            threshold: 'Threshold' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3'
                (mesh units).
            selected: 'Selected' in scripts. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_tri_to_quad_by_4_8_subdivision(self) -> Any:
        """MeshLab's filter 'Tri to Quad by 4-8 Subdivision'.

        Menus: remeshing, polygonal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_tri_to_quad_by_4_8_subdivision

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_tri_to_quad_by_smart_triangle_pairing(self) -> Any:
        """MeshLab's filter 'Tri to Quad by smart triangle pairing'.

        Menus: remeshing, polygonal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_tri_to_quad_by_smart_triangle_pairing

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_tri_to_quad_dominant(
        self,
        *,
        level: Literal["Fewest triangles", "(in between)", "Better quad shape"] = "Fewest triangles",
    ) -> Any:
        """MeshLab's filter 'Turn into Quad-Dominant mesh'.

        Menus: remeshing, polygonal. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_tri_to_quad_dominant

        Args:
            level: 'level' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def meshing_vertex_attribute_seam(
        self,
        *,
        normalmode: Literal["None", "Vertex", "Wedge", "Face"] = "None",
        colormode: Literal["None", "Vertex", "Wedge", "Face"] = "None",
        texcoordmode: Literal["None", "Vertex", "Wedge"] = "None",
    ) -> Any:
        """MeshLab's filter 'Vertex Attribute Seam'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#meshing_vertex_attribute_seam

        Args:
            normalmode: 'NormalMode' in scripts.
            colormode: 'ColorMode' in scripts.
            texcoordmode: 'TexcoordMode' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def nxs_build(
        self,
        *,
        input_file: str = "",
        output_file: str = "",
        node_faces: int = 32768,
        top_node_faces: int = 4096,
        tex_quality: int = 95,
        ram: int = 2000,
        skiplevels: int = 0,
        origin: PointLike = (0.0, 0.0, 0.0),
        center: bool = False,
        pow_2_textures: bool = False,
        deepzoom: bool = False,
        adaptive: float = 0.333,
    ) -> Any:
        """MeshLab's filter 'NXS Build'.

        Menus: other. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#nxs_build

        Args:
            input_file: 'input_file' in scripts. Takes the path of a file to read.
            output_file: 'output_file' in scripts. Takes the path of a file to write.
            node_faces: 'node_faces' in scripts. Takes a whole number of at least 0.
            top_node_faces: 'top_node_faces' in scripts. Takes a whole number of at least 0.
            tex_quality: 'tex_quality' in scripts. Takes a whole number of at least 0.
            ram: 'ram' in scripts. Takes a whole number of at least 0.
            skiplevels: 'skiplevels' in scripts. Takes a whole number of at least 0.
            origin: 'origin' in scripts. Takes three finite numbers.
            center: 'center' in scripts.
            pow_2_textures: 'pow_2_textures' in scripts.
            deepzoom: 'deepzoom' in scripts.
            adaptive: 'adaptive' in scripts. Takes a number from 0.0 to 1.0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def nxs_compress(
        self,
        *,
        input_file: str = "",
        output_file: str = "",
        nxz_vertex_quantization: float = 0.0,
        vertex_bits: int = 0,
        quantization_factor: float = 0.1,
        luma_bits: int = 6,
        chroma_bits: int = 6,
        alpha_bits: int = 5,
        normal_bits: int = 10,
        textures_precision: float = 0.25,
    ) -> Any:
        """MeshLab's filter 'NXS Compress'.

        Menus: other. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#nxs_compress

        Args:
            input_file: 'input_file' in scripts. Takes the path of a file to read.
            output_file: 'output_file' in scripts. Takes the path of a file to write.
            nxz_vertex_quantization: 'nxz_vertex_quantization' in scripts. Takes a number.
            vertex_bits: 'vertex_bits' in scripts. Takes a whole number of at least 0.
            quantization_factor: 'quantization_factor' in scripts. Takes a number.
            luma_bits: 'luma_bits' in scripts. Takes a whole number of at least 0.
            chroma_bits: 'chroma_bits' in scripts. Takes a whole number of at least 0.
            alpha_bits: 'alpha_bits' in scripts. Takes a whole number of at least 0.
            normal_bits: 'normal_bits' in scripts. Takes a whole number of at least 0.
            textures_precision: 'textures_precision' in scripts. Takes a number.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def raster_alignment_mutual_information(
        self,
        *,
        rendering_mode: Literal[
            "Combined", "Normal map", "Color per vertex", "Specular", "Silhouette", "Specular combined"
        ] = "Combined",
        shot: Any = ...,
        estimate_focal: bool = False,
        fine: bool = True,
        numofiterations: int = 100,
        tolerance: float = 0.1,
        expectedvariance: float = 2.0,
        backgroundweight: int = 2,
    ) -> Any:
        """MeshLab's filter 'Image alignment: Mutual Information'.

        Menus: camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#raster_alignment_mutual_information

        Args:
            rendering_mode: 'Rendering Mode' in scripts.
            shot: 'Shot' in scripts. Takes nothing: a camera cannot be given here. By default MeshLab chooses it for the mesh.
            estimate_focal: 'Estimate Focal' in scripts.
            fine: 'Fine' in scripts.
            numofiterations: 'NumOfIterations' in scripts. Takes a whole number from 0 to 100000.
            tolerance: 'Tolerance' in scripts. Takes a number.
            expectedvariance: 'ExpectedVariance' in scripts. Takes a number.
            backgroundweight: 'BackgroundWeight' in scripts. Takes a whole number of at least 0.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def raster_global_refinement_mutual_information(
        self,
        *,
        renderingmode: Literal[
            "Combined", "Normal map", "Color per vertex", "Specular", "Silhouette", "Specular combined"
        ] = "Combined",
        max_number_of_refinement_steps: int = 5,
        threshold_for_refinement_convergence: float = 1.2,
        pre_alignment: bool = False,
        estimate_focal: bool = True,
        fine: bool = True,
    ) -> Any:
        """MeshLab's filter 'Image Registration: Global refinement using Mutual Information'.

        Menus: camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#raster_global_refinement_mutual_information

        Args:
            renderingmode: 'RenderingMode' in scripts.
            max_number_of_refinement_steps: 'Max number of refinement steps' in scripts. Takes a whole number of at least 0.
            threshold_for_refinement_convergence: 'Threshold for refinement convergence' in scripts. Takes a number.
            pre_alignment: 'Pre-alignment' in scripts.
            estimate_focal: 'Estimate Focal' in scripts.
            fine: 'Fine' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def save_active_raster_cameras(
        self,
        *,
        exportfile: Literal["Bundler .out", "Agisoft xml"] = "Bundler .out",
        newname: str = "cameras",
    ) -> Any:
        """MeshLab's filter 'Export active rasters cameras to file'.

        Menus: raster layer. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#save_active_raster_cameras

        Args:
            exportfile: 'ExportFile' in scripts.
            newname: 'newName' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def save_snapshot(
        self,
        *,
        imagebackgroundcolor: ColorLike = (50, 50, 50, 255),
        imagewidth: int = 512,
        imageheight: int = 512,
        imagefilename: str = "gpu_generated_image.png",
    ) -> Any:
        """MeshLab's filter 'GPU Filter Example'.

        Menus: raster layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#save_snapshot

        Args:
            imagebackgroundcolor: 'ImageBackgroundColor' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue,
                opacity).
            imagewidth: 'ImageWidth' in scripts. Takes a whole number of at least 0.
            imageheight: 'ImageHeight' in scripts. Takes a whole number of at least 0.
            imagefilename: 'ImageFileName' in scripts. Takes the path of a file to write.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_camera_per_mesh(
        self,
        *,
        shot: Any = ...,
    ) -> Any:
        """MeshLab's filter 'Set Mesh Camera'.

        Menus: layer, camera. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_camera_per_mesh

        Args:
            shot: 'Shot' in scripts. Takes nothing: a camera cannot be given here. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_camera_per_raster(
        self,
        *,
        shot: Any = ...,
    ) -> Any:
        """MeshLab's filter 'Set Raster Camera'.

        Menus: raster layer, camera. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_camera_per_raster

        Args:
            shot: 'Shot' in scripts. Takes nothing: a camera cannot be given here. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_color_per_vertex(
        self,
        *,
        color1: ColorLike = (0, 0, 0, 255),
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Color Filling'.

        Menus: vertex coloring. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_color_per_vertex

        Args:
            color1: 'color1' in scripts. Takes four whole numbers from 0 to 255 (red, green, blue, opacity).
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_matrix(
        self,
        *,
        transformmatrix: MatrixLike = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
        compose: bool = False,
        freeze: bool = True,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Matrix: Set/Copy Transformation'.

        Menus: layer, normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_matrix

        Args:
            transformmatrix: 'TransformMatrix' in scripts. Takes a 4 x 4 matrix of finite numbers.
            compose: 'compose' in scripts.
            freeze: 'Freeze' in scripts.
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_matrix_identity(
        self,
        *,
        alllayers: bool = False,
    ) -> Any:
        """MeshLab's filter 'Matrix: Reset Current Matrix'.

        Menus: layer, normal. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_matrix_identity

        Args:
            alllayers: 'allLayers' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_mesh_name(
        self,
        *,
        newname: str = ...,
    ) -> Any:
        """MeshLab's filter 'Rename Current Mesh'.

        Menus: layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_mesh_name

        Args:
            newname: 'newName' in scripts. Takes a text. By default MeshLab chooses it for the mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_raster_name(
        self,
        *,
        newname: str = "",
    ) -> Any:
        """MeshLab's filter 'Rename Current Raster'.

        Menus: raster layer. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_raster_name

        Args:
            newname: 'newName' in scripts. Takes a text.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_selection_all(
        self,
        *,
        allfaces: bool = True,
        allverts: bool = True,
    ) -> Any:
        """MeshLab's filter 'Select All'.

        Menus: selection. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_selection_all

        Args:
            allfaces: 'allFaces' in scripts.
            allverts: 'allVerts' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_selection_none(
        self,
        *,
        allfaces: bool = True,
        allverts: bool = True,
    ) -> Any:
        """MeshLab's filter 'Select None'.

        Menus: selection. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_selection_none

        Args:
            allfaces: 'allFaces' in scripts.
            allverts: 'allVerts' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def set_texture_per_mesh(
        self,
        *,
        textname: str = "",
        use_dummy_texture: bool = False,
        dummy_img_size: int = 512,
        dummy_check_size: int = 8,
        dummy_type: Literal["Checkboard", "Grid"] = "Checkboard",
    ) -> Any:
        """MeshLab's filter 'Set Texture'.

        Menus: texture. What it does: https://pymeshlab.readthedocs.io/en/latest/filter_list.html#set_texture_per_mesh

        Args:
            textname: 'textName' in scripts. Takes the path of a file to read.
            use_dummy_texture: 'use_dummy_texture' in scripts.
            dummy_img_size: 'dummy_img_size' in scripts. Takes a whole number of at least 0.
            dummy_check_size: 'dummy_check_size' in scripts. Takes a whole number of at least 0.
            dummy_type: 'dummy_type' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def transfer_attributes_per_vertex(
        self,
        *,
        sourcemesh: int = ...,
        targetmesh: int = ...,
        vertexsampling: bool = False,
        geomtransfer: bool = False,
        normaltransfer: bool = False,
        colortransfer: bool = True,
        qualitytransfer: bool = False,
        selectiontransfer: bool = False,
        qualitydistance: bool = False,
        savebarycentric: bool = False,
        upperbound: LengthLike = "2%",
        onselected: bool = False,
    ) -> Any:
        """MeshLab's filter 'Vertex Attribute Transfer'.

        Menus: sampling. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#transfer_attributes_per_vertex

        Args:
            sourcemesh: 'SourceMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            targetmesh: 'TargetMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            vertexsampling: 'VertexSampling' in scripts.
            geomtransfer: 'GeomTransfer' in scripts.
            normaltransfer: 'NormalTransfer' in scripts.
            colortransfer: 'ColorTransfer' in scripts.
            qualitytransfer: 'QualityTransfer' in scripts.
            selectiontransfer: 'SelectionTransfer' in scripts.
            qualitydistance: 'QualityDistance' in scripts.
            savebarycentric: 'SaveBarycentric' in scripts.
            upperbound: 'UpperBound' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or
                '0.3' (mesh units).
            onselected: 'onSelected' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def transfer_attributes_to_texture_per_vertex(
        self,
        *,
        sourcemesh: int = ...,
        targetmesh: int = ...,
        attributeenum: Literal["Vertex Color", "Vertex Normal", "Vertex Quality", "Texture Color"] = "Vertex Color",
        upperbound: LengthLike = "2%",
        textname: str = ...,
        textw: int = 1024,
        texth: int = 1024,
        overwrite: bool = False,
        pullpush: bool = True,
    ) -> Any:
        """MeshLab's filter 'Transfer: Vertex Attributes to Texture (1 or 2 meshes)'.

        Menus: texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#transfer_attributes_to_texture_per_vertex

        Args:
            sourcemesh: 'sourceMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            targetmesh: 'targetMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            attributeenum: 'AttributeEnum' in scripts.
            upperbound: 'upperBound' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or
                '0.3' (mesh units).
            textname: 'textName' in scripts. Takes a text. By default MeshLab chooses it for the mesh.
            textw: 'textW' in scripts. Takes a whole number of at least 0.
            texth: 'textH' in scripts. Takes a whole number of at least 0.
            overwrite: 'overwrite' in scripts.
            pullpush: 'pullpush' in scripts.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def transfer_iso_parametrization_between_meshes(
        self,
        *,
        sourcemesh: int = ...,
        targetmesh: int = ...,
    ) -> Any:
        """MeshLab's filter 'Iso Parametrization transfer between meshes'.

        Menus: remeshing. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#transfer_iso_parametrization_between_meshes

        Args:
            sourcemesh: 'sourceMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            targetmesh: 'targetMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """

    def transfer_texture_to_color_per_vertex(
        self,
        *,
        sourcemesh: int = ...,
        targetmesh: int = ...,
        upperbound: LengthLike = "2%",
    ) -> Any:
        """MeshLab's filter 'Transfer: Texture to Vertex Color (1 or 2 meshes)'.

        Menus: vertex coloring, texture. What it does:
        https://pymeshlab.readthedocs.io/en/latest/filter_list.html#transfer_texture_to_color_per_vertex

        Args:
            sourcemesh: 'sourceMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            targetmesh: 'targetMesh' in scripts. Takes the id of a layer (a whole number). By default MeshLab chooses it for the
                mesh.
            upperbound: 'upperBound' in scripts. Takes a length such as '1%' (of the bounding box's diagonal), '0.5edge' or
                '0.3' (mesh units).

        Returns:
            What the filter reports, by name; None if it reports nothing.
        """
