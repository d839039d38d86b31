// A plain multi-goal A* by the planner's rules, for `vizbot bench planner` to be measured against.
//
// Moves lead to the 8 neighbours; one costs its length times the mean cost of its two cells, and a
// diagonal needs both cells beside it passable. The heuristic is the least cost times the octile
// distance to the nearest goal, goal cost included: taken over all goals for each cell that is
// opened, or, with many goals, by two sweeps over the whole grid beforehand. Arrays are kept from
// call to call, so that no time goes into memory.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <queue>
#include <vector>

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
const double kDiagonal = std::sqrt(2.0);

struct Goal {
  int row, col;
  double cost;
};

struct Entry {
  double key;
  int cell;
  bool operator<(const Entry& other) const { return key > other.key; }
};

double nearest(const std::vector<Goal>& goals, int row, int col, double unit) {
  double best = kInf;
  for (const Goal& goal : goals) {
    const int down = std::abs(goal.row - row), right = std::abs(goal.col - col);
    const double away = std::max(down, right) + (kDiagonal - 1.0) * std::min(down, right);
    best = std::min(best, goal.cost + away * unit);
  }
  return best;
}

// The same for every cell at once.
void sweep_goals(const std::vector<Goal>& goals, int rows, int cols, double unit,
                 std::vector<double>& field) {
  field.assign(static_cast<size_t>(rows) * cols, kInf);
  for (const Goal& goal : goals) {
    double& here = field[static_cast<size_t>(goal.row) * cols + goal.col];
    here = std::min(here, goal.cost);
  }
  const double slant = unit * kDiagonal;
  for (int sweep = 0; sweep < 2; ++sweep) {
    const int way = sweep == 0 ? 1 : -1;
    for (int i = 0; i < rows; ++i) {
      const int row = sweep == 0 ? i : rows - 1 - i;
      double* line = &field[static_cast<size_t>(row) * cols];
      const double* before = i > 0 ? line - static_cast<ptrdiff_t>(way) * cols : nullptr;
      if (before) {
        for (int col = 0; col < cols; ++col) {
          double best = std::min(line[col], before[col] + unit);
          if (col > 0) best = std::min(best, before[col - 1] + slant);
          if (col + 1 < cols) best = std::min(best, before[col + 1] + slant);
          line[col] = best;
        }
      }
      double beside = kInf;
      for (int j = 0; j < cols; ++j) {
        const int col = sweep == 0 ? j : cols - 1 - j;
        beside = line[col] = std::min(line[col], beside + unit);
      }
    }
  }
}

}  // namespace

// Returns the cost of the cheapest path, infinity without one. `goals` holds rows and columns;
// cells of the path go to `path`, the goal's first, their number to `length`.
extern "C" double plan(const float* cost, int rows, int cols, double resolution, double least,
                       int start, const int64_t* goal_cells, const double* goal_costs, int count,
                       int sweep, int* path, int* length) {
  const double unit = least * resolution, steps[2] = {resolution, resolution * kDiagonal};
  const size_t size = static_cast<size_t>(rows) * cols;
  static std::vector<double> reached, field;
  static std::vector<int> parent;
  static std::vector<uint8_t> is_goal, closed;
  reached.assign(size, kInf);
  parent.assign(size, -1);
  is_goal.assign(size, 0);
  closed.assign(size, 0);
  std::vector<Goal> goals;
  for (int i = 0; i < count; ++i) {
    const int row = static_cast<int>(goal_cells[2 * i]), col = static_cast<int>(goal_cells[2 * i + 1]);
    if (row < 0 || row >= rows || col < 0 || col >= cols) continue;
    if (std::isinf(cost[static_cast<size_t>(row) * cols + col])) continue;
    goals.push_back({row, col, goal_costs[i]});
    is_goal[static_cast<size_t>(row) * cols + col] = 1;
  }
  if (sweep) sweep_goals(goals, rows, cols, unit, field);
  const auto to_go = [&](int cell) {
    return sweep ? field[cell] : nearest(goals, cell / cols, cell % cols, unit);
  };

  std::priority_queue<Entry> open;
  reached[start] = 0.0;
  open.push({to_go(start), start});
  double total = kInf;
  int best = -1;
  while (!open.empty() && open.top().key < total) {
    const int cell = open.top().cell;
    open.pop();
    if (closed[cell]) continue;
    closed[cell] = 1;
    const int row = cell / cols, col = cell % cols;
    if (is_goal[cell]) {
      for (const Goal& goal : goals) {
        if (goal.row == row && goal.col == col && reached[cell] + goal.cost < total) {
          total = reached[cell] + goal.cost;
          best = cell;
        }
      }
    }
    for (int down = -1; down <= 1; ++down) {
      if (row + down < 0 || row + down >= rows) continue;
      for (int right = -1; right <= 1; ++right) {
        if (col + right < 0 || col + right >= cols) continue;
        const int there = cell + down * cols + right;
        if (closed[there] || std::isinf(cost[there])) continue;
        const bool slanted = down != 0 && right != 0;
        if (slanted && (std::isinf(cost[cell + down * cols]) || std::isinf(cost[cell + right]))) continue;
        const double along =
            reached[cell] + 0.5 * steps[slanted] * (static_cast<double>(cost[cell]) + cost[there]);
        if (along < reached[there]) {
          reached[there] = along;
          parent[there] = cell;
          open.push({along + to_go(there), there});
        }
      }
    }
  }
  *length = 0;
  for (int cell = best; cell >= 0; cell = parent[cell]) path[(*length)++] = cell;
  return total;
}
