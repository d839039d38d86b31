"""The paper's Algorithm 1: where the robot goes for a goal, given the maps of this moment.

The pseudo-code, with its lines counted:

     1  Input: object-goal q_t
     2  Observe: RGB image I_t, depth image D_t
     3  Output: action a_t
     4  P_t <- DroidSLAM(P_t-1, I_t, D_t)
     5  M^Depth_t <- DepthMapper(M^Depth_t-1, D_t, P_t)
     6  M^CLIP_t <- CLIPMapper(M^CLIP_t-1, I_t, D_t, P_t)
     7  g_t <- Find(M^CLIP_t-1, q_t, theta)
     8  if g_t is not empty:
     9      a_t <- Navigation(M^Depth_t, g_t, P_t)
    10  end if
    11  if g_t is empty or a_t is empty:
    12      a_t <- Navigation(M^Depth_t, g_distant, P_t)
    13      while a_t is empty:
    14          theta <- theta - 0.001
    15          g_t <- Find(M^CLIP_t-1, q_t, theta)
    16          if g_t is not empty:
    17              a_t <- Navigation(M^Depth_t, g_t, P_t)
    18          end if
    19      end while
    20  end if
    21  return a_t

`vizbot.pipeline` does lines 1 to 6, and `objectnav` the rest.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, replace
from functools import cache

from mapping.clip.retrieval import find
from nav.config import NavigatorConfig
from nav.navigator import Navigation
from vizbot.config import ObjectNavConfig
from vizbot.objectnav.approach import NavigationState, approach
from vizbot.objectnav.exploration import Exploration
from vizbot.objectnav.tasks import Goal
from vizbot.perception.sightings import Sightings


@dataclass(frozen=True, slots=True)
class Theta:
    """The threshold of one step.

    Attributes:
        start: The algorithm's input. What is lowered in a closed space does not outlive the step,
            so that a better view later counts again.
        floor: The least theta; the paper has none.
        lower_first: Whether theta is lowered before the robot explores. The paper explores first.
    """

    start: float
    floor: float
    lower_first: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Action:
    """What Algorithm 1 returns as a_t.

    Attributes:
        navigation: The way to go and the twist to begin it.
        exploring: Whether it leads into the unknown rather than to something found.
        threshold: Theta after lowering.
    """

    navigation: Navigation
    exploring: bool
    threshold: float


def objectnav(
    goal: Goal,
    sightings: Sightings,
    theta: Theta,
    state: NavigationState,
    exploration: Exploration,
    config: ObjectNavConfig,
    navigator: NavigatorConfig,
) -> Action | None:
    """Decide once by lines 7 to 21 of Algorithm 1 (paper, section III-C).

    Args:
        goal: The paper's q_t.
        sightings: M^CLIP with the similarities to the goal.
        theta: Threshold of this step.
        state: M^Depth, P_t and the navigation of the previous step.
        exploration: Leads into the unknown, in place of g_distant alone.
        config: How many views must agree, how near the robot goes, by how much theta is lowered.
        navigator: How the robot drives.

    Returns:
        None when nothing is left to explore and nothing above the floor can be reached: the goal is
        not found.
    """
    agreed = replace(sightings, similarities=sightings.agreed(config.agreement, theta.floor))

    @cache
    def find_and_navigate(threshold: float) -> Action | None:
        found = agreed.take(find(agreed.similarities, threshold))  # lines 7 and 15
        navigation = approach(  # lines 8, 9, 16 and 17
            found, config.reaches, config.similarity_worth, state, navigator
        )
        return None if navigation is None else Action(navigation, False, threshold)

    def lower_until_reached() -> Action | None:
        count = int((theta.start - theta.floor) / config.threshold_step) + 1
        lowered = [theta.start - i * config.threshold_step for i in range(count)]  # line 14
        # What can be reached can still be reached with a lower theta: no need to try each.
        first = bisect_left(lowered, True, key=lambda each: find_and_navigate(each) is not None)
        return find_and_navigate(lowered[first]) if first < len(lowered) else None

    action = find_and_navigate(theta.start)  # lines 7 to 10
    if action is None and theta.lower_first:
        action = lower_until_reached()
    if action is None:  # line 11
        unknown = exploration.to_suspects_or_unknown(sightings, goal.threshold, state)  # line 12
        if unknown is not None:
            action = Action(unknown, True, theta.start)
        elif not theta.lower_first:
            action = lower_until_reached()  # lines 13 to 19
    return action  # line 21
