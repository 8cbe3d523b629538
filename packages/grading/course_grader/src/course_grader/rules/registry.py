"""All rules by their names in ``checks`` of an exercise file."""
from typing import Dict, Type

from course_grader.rules import rules_driving, rules_navigation, rules_output, rules_state
from course_grader.rules.judging import Rule

RULES: Dict[str, Type[Rule]] = {
    'draws': rules_driving.Draws,
    'commands': rules_driving.Commands,
    'moves': rules_driving.Moves,
    'stops': rules_driving.Stops,
    'passes': rules_driving.Passes,
    'same_path': rules_driving.SamePath,
    'apart': rules_driving.Apart,
    'repeats': rules_driving.Repeats,
    'keeps': rules_state.Keeps,
    'steers': rules_state.Steers,
    'positions': rules_driving.Positions,
    'pen': rules_driving.Pen,
    'prints': rules_output.Prints,
    'prints_poses': rules_output.PrintsPoses,
    'answers': rules_output.Answers,
    'reaches': rules_output.Reaches,
    'prints_markers': rules_output.PrintsMarkers,
    'prints_no_marker': rules_output.PrintsNoMarker,
    'connects': rules_output.Connects,
    'parameter': rules_state.HasParameter,
    'background': rules_state.Background,
    'transform': rules_state.HasTransform,
    'spawns': rules_state.Spawns,
    'follows': rules_state.Follows,
    'maps': rules_navigation.Maps,
    'localises': rules_navigation.Localises,
    'navigates': rules_navigation.Navigates,
    'runs': rules_output.Runs,
}
