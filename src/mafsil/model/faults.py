"""The catalogue of faults of robot files: code, severity, sentence key.

Letters: F file and XML, N number, S structure, J joint, I inertia, G geometry and assets, M only in MJCF,
X only in xacro, D only in SDFormat, T tables.
"""

from mafsil.model.diagnostics import Fault, Severity

FAULTS: dict[str, Fault] = {}
"""Every fault of this catalogue by its code."""


def _fault(code: str, severity: Severity, name: str) -> Fault:
    if code in FAULTS:
        raise ValueError(code)
    FAULTS[code] = Fault(code, severity, f"robotfile.{name}")
    return FAULTS[code]


def _error(code: str, name: str) -> Fault:
    return _fault(code, Severity.ERROR, name)


def _warning(code: str, name: str) -> Fault:
    return _fault(code, Severity.WARNING, name)


def _info(code: str, name: str) -> Fault:
    return _fault(code, Severity.INFO, name)


# File and XML
FILE_MISSING = _error("F0101", "file_missing")
NOT_A_FILE = _error("F0102", "not_a_file")
TOO_LARGE = _error("F0103", "too_large")
EMPTY = _error("F0104", "empty")
NUL_BYTE = _error("F0105", "nul_byte")
ENCODING = _error("F0106", "encoding")
UNKNOWN_ENCODING = _error("F0107", "unknown_encoding")
BYTE_ORDER_MARK = _info("F0108", "byte_order_mark")
CONVERTED_ENCODING = _warning("F0109", "converted_encoding")
MALFORMED = _error("F0110", "malformed")
CUT_SHORT = _error("F0111", "cut_short")
MISMATCHED_TAG = _error("F0112", "mismatched_tag")
DUPLICATE_ATTRIBUTE = _error("F0113", "duplicate_attribute")
JUNK_AFTER_END = _warning("F0114", "junk_after_end")
UNDEFINED_ENTITY = _warning("F0115", "undefined_entity")
DOCTYPE = _error("F0116", "doctype")
COMMENT_HYPHENS = _warning("F0117", "comment_hyphens")
DECLARATION_PARDONED = _warning("F0118", "declaration_pardoned")
NO_BLANK = _warning("F0119", "no_blank")
STRAY_CHARACTER = _warning("F0124", "stray_character")
STRAY_MARKUP = _warning("F0125", "stray_markup")
GUESSED_ENCODING = _warning("F0126", "guessed_encoding")
WRONG_ENCODING = _warning("F0127", "wrong_encoding")
EMPTY_ATTRIBUTE = _warning("F0128", "empty_attribute")
DOCUMENT_TYPE = _warning("F0129", "document_type")
TOO_MANY_ELEMENTS = _error("F0120", "too_many_elements")
TOO_MANY_LINKS = _error("F0121", "too_many_links")
TOO_DEEP = _error("F0122", "too_deep")
TOO_MANY_ATTRIBUTES = _error("F0123", "too_many_attributes")
WRONG_ROOT = _error("F0130", "wrong_root")
ONLY_MACROS = _error("F0131", "only_macros")
TOO_MANY_ERRORS = _error("F0132", "too_many_errors")
UNKNOWN_ELEMENT = _warning("F0133", "unknown_element")
REPEATED_ELEMENT = _warning("F0134", "repeated_element")
MISSING_ELEMENT = _error("F0135", "missing_element")
MORE_REMARKS = _info("F0137", "more_remarks")
IGNORED_ELEMENT = _info("F0136", "ignored_element")
NO_ARGUMENTS = _error("F0138", "no_arguments")
FOREIGN_ATTRIBUTE = _warning("F0139", "foreign_attribute")
OTHER_VERSION = _warning("F0140", "other_version")
UNKNOWN_VERSION = _error("F0141", "unknown_version")
NO_MODELS = _error("F0142", "no_models")

# Numbers
MISSING_ATTRIBUTE = _error("N0201", "missing_attribute")
NOT_A_NUMBER = _error("N0202", "not_a_number")
NOT_FINITE = _error("N0203", "not_finite")
OVERFLOW = _error("N0204", "overflow")
WRONG_COUNT = _error("N0205", "wrong_count")
UNDERFLOW = _warning("N0206", "underflow")
TOO_BIG = _error("N0207", "too_big")
DECIMAL_COMMA = _error("N0208", "decimal_comma")
HEXADECIMAL = _error("N0209", "hexadecimal")
LOCAL_DIGITS = _error("N0210", "local_digits")
WITH_UNIT = _error("N0211", "with_unit")
ZERO_QUATERNION = _error("N0212", "zero_quaternion")
TWO_ROTATIONS = _error("N0213", "two_rotations")
QUATERNION_NORMALISED = _warning("N0214", "quaternion_normalised")

# Structure
NO_NAME = _error("S0301", "no_name")
STRANGE_NAME = _warning("S0302", "strange_name")
DUPLICATE_LINK = _error("S0303", "duplicate_link")
DUPLICATE_JOINT = _error("S0304", "duplicate_joint")
UNKNOWN_LINK = _error("S0305", "unknown_link")
SELF_JOINT = _error("S0306", "self_joint")
TWO_PARENTS = _error("S0307", "two_parents")
TWO_ROOTS = _error("S0308", "two_roots")
CYCLE = _error("S0309", "cycle")
NO_LINKS = _error("S0310", "no_links")
INCONSISTENT = _error("S0312", "inconsistent")
NAMELESS_ROBOT = _warning("S0311", "nameless_robot")

# Joints
UNKNOWN_TYPE = _error("J0401", "unknown_type")
FLOATING_BASE = _warning("J0402", "floating_base")
SEVERAL_FREEDOMS = _error("J0403", "several_freedoms")
ZERO_AXIS = _error("J0404", "zero_axis")
AXIS_NORMALISED = _warning("J0405", "axis_normalised")
DEFAULT_AXIS = _warning("J0406", "default_axis")
NO_LIMIT = _warning("J0410", "no_limit")
NO_RANGE = _warning("J0411", "no_range")
LIMITS_INVERTED = _error("J0412", "limits_inverted")
LIMITS_EXCHANGED = _warning("J0428", "limits_exchanged")
LIMITS_EQUAL = _warning("J0413", "limits_equal")
EMPTY_RANGE = _warning("J0414", "empty_range")
NO_BOUND = _warning("J0415", "no_bound")
ZERO_BOUND = _warning("J0416", "zero_bound")
NEGATIVE_BOUND = _error("J0417", "negative_bound")
HALF_RANGE = _warning("J0419", "half_range")
UNUSED_RANGE = _info("J0418", "unused_range")
MIMIC_LEADER_MISSING = _warning("J0420", "mimic_leader_missing")
MIMIC_ITSELF = _error("J0421", "mimic_itself")
MIMIC_CYCLE = _error("J0422", "mimic_cycle")
MIMIC_CHAIN = _info("J0423", "mimic_chain")
MIMIC_ON_FIXED = _info("J0424", "mimic_on_fixed")
MIMIC_LEADER_FIXED = _warning("J0425", "mimic_leader_fixed")
MIMIC_OVERFLOW = _error("J0427", "mimic_overflow")
MIMIC_ZERO = _warning("J0426", "mimic_zero")
NEGATIVE_DAMPING = _error("J0430", "negative_damping")
SAFETY_IGNORED = _info("J0431", "safety_ignored")
TRANSMISSION_IGNORED = _info("J0432", "transmission_ignored")
BOUND_OF_NONE = _warning("J0433", "bound_of_none")
INFINITE_BOUND = _warning("J0434", "infinite_bound")
UNEVEN_ACCELERATION = _warning("J0435", "uneven_acceleration")
OPEN_RANGE = _warning("J0436", "open_range")

# Inertia
NO_INERTIAL = _info("I0501", "no_inertial")
ZERO_MASS = _warning("I0502", "zero_mass")
NEGATIVE_MASS = _error("I0503", "negative_mass")
NEGATIVE_MOMENT = _error("I0504", "negative_moment")
NOT_POSITIVE = _warning("I0505", "not_positive")
TRIANGLE = _warning("I0506", "triangle")
ZERO_INERTIA = _warning("I0507", "zero_inertia")
MASSLESS_INERTIA = _warning("I0508", "massless_inertia")
TENSOR_INCOMPLETE = _warning("I0509", "tensor_incomplete")

# Geometry and assets
NO_GEOMETRY = _warning("G0601", "no_geometry")
UNKNOWN_GEOMETRY = _warning("G0602", "unknown_geometry")
BAD_SIZE = _error("G0603", "bad_size")
ZERO_SCALE = _error("G0604", "zero_scale")
PATH_ESCAPES = _error("G0610", "path_escapes")
PATH_NOT_ALLOWED = _warning("G0611", "path_not_allowed")
PACKAGE_NOT_FOUND = _warning("G0612", "package_not_found")
FILE_NOT_FOUND = _warning("G0613", "file_not_found")
UNKNOWN_SCHEME = _warning("G0614", "unknown_scheme")
BAD_COLOUR = _warning("G0620", "bad_colour")
UNKNOWN_MATERIAL = _info("G0621", "unknown_material")

# Only in MJCF
UNSUPPORTED = _error("M0701", "unsupported")
NOT_KEPT = _warning("M0702", "not_kept")
INCLUDE_REFUSED = _error("M0703", "include_refused")
INCLUDE_TWICE = _error("M0704", "include_twice")
UNKNOWN_CLASS = _error("M0705", "unknown_class")
UNKNOWN_CHOICE = _error("M0706", "unknown_choice")
FREE_JOINT = _error("M0710", "free_joint")
BALL_JOINT = _warning("M0711", "ball_joint")
UNKNOWN_JOINT = _error("M0712", "unknown_joint")
UNKNOWN_BODY = _error("M0713", "unknown_body")
NO_ROTATION = _error("M0714", "no_rotation")
MESH_WITHOUT_MASS = _error("M0717", "mesh_without_mass")
UNKNOWN_ASSET = _error("M0718", "unknown_asset")
UNKNOWN_ATTRIBUTE = _error("M0719", "unknown_attribute")
UNKNOWN_PART = _error("M0720", "unknown_part")
BASE_FIXED = _warning("M0721", "base_fixed")
LOOSE_OBJECT = _warning("M0722", "loose_object")
LOOP_OPEN = _warning("M0723", "loop_open")
TENDON_ARMATURE = _error("M0724", "tendon_armature")
NO_SUCH_PART = _error("M0725", "no_such_part")
SECOND_INERTIAL = _error("M0726", "second_inertial")
UNKNOWN_SITE = _error("M0727", "unknown_site")
LOOP_CLOSED = _warning("M0728", "loop_closed")
LOOSE_HELD = _warning("M0729", "loose_held")
BALL_ARMATURE = _error("M0730", "ball_armature")

# Only in xacro
XACRO_MACRO = _error("X1101", "xacro_macro")
XACRO_FOREIGN_PARAMETER = _error("X1102", "xacro_foreign_parameter")
XACRO_PARAMETER = _error("X1103", "xacro_parameter")
XACRO_BLOCKS = _error("X1104", "xacro_blocks")
XACRO_BLOCK = _error("X1105", "xacro_block")
XACRO_EXPRESSION = _error("X1106", "xacro_expression")
XACRO_UNDEFINED = _error("X1107", "xacro_undefined")
XACRO_CIRCULAR = _error("X1108", "xacro_circular")
XACRO_CONDITION = _error("X1109", "xacro_condition")
XACRO_ARGUMENT = _error("X1110", "xacro_argument")
XACRO_PACKAGE = _error("X1111", "xacro_package")
XACRO_FILE = _error("X1112", "xacro_file")
XACRO_TOO_MUCH = _error("X1113", "xacro_too_much")
XACRO_INCLUDES = _error("X1114", "xacro_includes")
XACRO_NAME = _error("X1115", "xacro_name")
XACRO_COMMAND = _error("X1116", "xacro_command")
XACRO_ENVIRONMENT = _error("X1117", "xacro_environment")
XACRO_TEXT = _error("X1118", "xacro_text")
XACRO_YAML = _error("X1119", "xacro_yaml")
XACRO_ATTRIBUTE = _error("X1120", "xacro_attribute")
XACRO_UNUSED_ARGUMENT = _warning("X1121", "xacro_unused_argument")
XACRO_LEFT_OVER = _warning("X1122", "xacro_left_over")

# Only in SDFormat
SDF_JOINT = _error("D1201", "sdf_joint")
SDF_FRAME = _error("D1202", "sdf_frame")
SDF_CIRCLE = _error("D1203", "sdf_circle")
SDF_MODELS = _error("D1204", "sdf_models")
SDF_LOOSE = _warning("D1205", "sdf_loose")
SDF_INCLUDE = _error("D1206", "sdf_include")
SDF_INCLUDE_LEFT = _warning("D1207", "sdf_include_left")
SDF_DEFAULT_MASS = _warning("D1208", "sdf_default_mass")
SDF_FLOATING = _warning("D1209", "sdf_floating")
SDF_CHOICE = _error("D1210", "sdf_choice")
SDF_QUATERNION = _error("D1211", "sdf_quaternion")
SDF_AUTO = _warning("D1212", "sdf_auto")
SDF_GEARBOX = _error("D1213", "sdf_gearbox")
SDF_GEARBOX_RATIO = _error("D1214", "sdf_gearbox_ratio")
SDF_NO_MODEL = _error("D1215", "sdf_no_model")

# Tables
DH_DEGREES = _warning("T1301", "dh_degrees")

PARDONED = frozenset(
    {
        JUNK_AFTER_END, UNDEFINED_ENTITY, COMMENT_HYPHENS, DECLARATION_PARDONED, NO_BLANK, STRAY_CHARACTER,
        STRAY_MARKUP, DOCUMENT_TYPE, GUESSED_ENCODING, WRONG_ENCODING, EMPTY_ATTRIBUTE, BOUND_OF_NONE, INFINITE_BOUND,
    }
)  # fmt: skip
"""What we and some other readers take and the rest refuse: mended with the errors, as it changes no meaning."""
