"""Pictures of lines and of trees, by queries of a tree: depth images as in the thesis, and levels of trees."""

from .default_view import ViewOptions, complete_size, default_camera, default_size, default_view, turntable_camera
from .levels import level_sheet
from .measure_renderer import MeasureRenderer
from .measures import MEASURES, Measure
from .node_visits import visited_nodes
from .pictures.frames import FRAME_FORMATS, check_frames_path, numbered, write_frames
from .pictures.images import IMAGE_FORMATS, check_image_path, write_depth, write_picture
from .pictures.picture import Picture
from .plan import PictureOptions, PicturePlan, plan_picture
from .progressive import Progressive
from .refinement import Pace, refined, report_if_long
from .renderer import Renderer, finish, render, renderer_of
from .sequences import radius_sweep, spaced_radii, turntable
from .shading.aovs import AOVS, find_aovs
from .shading.depth import MAX_PIXELS, depth_image

__all__ = [
    "AOVS",
    "FRAME_FORMATS",
    "IMAGE_FORMATS",
    "MAX_PIXELS",
    "MEASURES",
    "Measure",
    "MeasureRenderer",
    "Pace",
    "Picture",
    "PictureOptions",
    "PicturePlan",
    "Progressive",
    "Renderer",
    "ViewOptions",
    "check_frames_path",
    "check_image_path",
    "complete_size",
    "default_camera",
    "default_size",
    "default_view",
    "depth_image",
    "find_aovs",
    "finish",
    "level_sheet",
    "numbered",
    "plan_picture",
    "radius_sweep",
    "refined",
    "render",
    "renderer_of",
    "report_if_long",
    "spaced_radii",
    "turntable",
    "turntable_camera",
    "visited_nodes",
    "write_depth",
    "write_frames",
    "write_picture",
]
