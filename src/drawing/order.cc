#include "impedraw/drawing/order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>
#include <nanoflann.hpp>

#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr int kNeighbours = 10;  // per end: ends of other strokes
constexpr int kLongestMove = 3;  // strokes that Or-opt moves at once
constexpr int kShakenRun = 30;   // strokes in a run that is swapped
constexpr int kMostShakes = 100000;
constexpr double kGain = 1e-9;  // [mm]; less is rounding

// Ends of strokes: end 2 s is the start of stroke s, end 2 s + 1 its end.
struct Ends {
  std::vector<Vector2d> p;
  std::size_t kdtree_get_point_count() const { return p.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return p[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

std::vector<std::array<int, kNeighbours>> neighbours_of(const Ends& ends) {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Ends>, Ends,
                                                   2, std::size_t>;
  const Tree tree(2, ends);
  std::vector<std::array<int, kNeighbours>> neighbours(ends.p.size());
  std::array<std::size_t, kNeighbours + 2> index;
  std::array<double, kNeighbours + 2> squared;
  for (std::size_t e = 0; e < ends.p.size(); ++e) {
    const std::size_t found =
        tree.knnSearch(ends.p[e].data(), index.size(), index.data(), squared.data());
    int n = 0;
    for (std::size_t i = 0; i < found && n < kNeighbours; ++i) {
      if (index[i] / 2 != e / 2) neighbours[e][n++] = static_cast<int>(index[i]);
    }
    std::fill(neighbours[e].begin() + n, neighbours[e].end(), -1);
  }
  return neighbours;
}

// Finds the nearest of the points that are left, the first of equally near ones.
class NearestLeft {
 public:
  explicit NearestLeft(const Ends& points) : points_(points), left_(points.p.size()) {
    Eigen::AlignedBox2d box;
    for (const Vector2d& p : points.p) box.extend(p);
    origin_ = box.min();
    // About two points a cell.
    const double sides = std::sqrt(static_cast<double>(points.p.size()) / 2);
    cell_ = std::max(box.sizes().maxCoeff() / std::max(1.0, sides), 1e-9);
    columns_ = 1 + static_cast<int>(box.sizes().x() / cell_);
    rows_ = 1 + static_cast<int>(box.sizes().y() / cell_);
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (std::size_t i = 0; i < points.p.size(); ++i)
      cells_[cell_of(points.p[i])].push_back(static_cast<int>(i));
  }

  void remove(int point) {
    std::vector<int>& cell = cells_[cell_of(points_.p[point])];
    left_ -= std::erase(cell, point);
  }

  // −1: none is left.
  int nearest(const Vector2d& p) const {
    if (left_ == 0) return -1;
    const int column = column_of(p), row = row_of(p);
    int best = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int ring = 0; (ring - 1) * cell_ <= least; ++ring) {
      for (int r = std::max(0, row - ring); r <= std::min(rows_ - 1, row + ring); ++r) {
        const bool whole = r == row - ring || r == row + ring;
        for (int c = column - ring; c <= column + ring; c += whole ? 1 : std::max(1, 2 * ring)) {
          if (c < 0 || c >= columns_) continue;
          for (const int i : cells_[index(c, r)]) {
            const double d = (points_.p[i] - p).norm();
            if (d < least || (d == least && i < best)) least = d, best = i;
          }
        }
      }
    }
    return best;
  }

 private:
  int column_of(const Vector2d& p) const { return static_cast<int>((p.x() - origin_.x()) / cell_); }
  int row_of(const Vector2d& p) const { return static_cast<int>((p.y() - origin_.y()) / cell_); }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  std::size_t cell_of(const Vector2d& p) const { return index(column_of(p), row_of(p)); }

  const Ends& points_;
  std::size_t left_;
  Vector2d origin_;
  double cell_;
  int columns_, rows_;
  std::vector<std::vector<int>> cells_;
};

// An open tour through the strokes. Each place holds the end at which the pen enters.
class Tour {
 public:
  Tour(Ends ends, std::function<void(double)> progress)
      : progress_(std::move(progress)),
        ends_(std::move(ends)),
        near_(neighbours_of(ends_)),
        count_(static_cast<int>(ends_.p.size() / 2)) {
    greedy();
    place_.resize(count_);
    for (int k = 0; k < count_; ++k) place_[entry_[k] / 2] = k;
  }

  void improve() {
    std::deque<int> all(ends_.p.size());
    std::iota(all.begin(), all.end(), 0);
    queue_ = std::move(all);
    queued_.assign(ends_.p.size(), true);
    // About two looks at each end suffice.
    settle([&, looks = std::size_t{0}]() mutable {
      if (++looks % 1024 == 0)
        tell(0.5 * std::min(1.0, static_cast<double>(looks) /
                                     (2.0 * static_cast<double>(ends_.p.size()))));
    });
  }

  void shake(int times) {
    if (count_ < 8) return;
    std::mt19937 random(1);
    const auto up_to = [&](int n) {
      return 1 + static_cast<int>(random() % static_cast<unsigned>(n));
    };
    for (int i = 0; i < times; ++i) {
      if (i % 1024 == 0) tell(0.5 + 0.5 * i / times);
      const int longest = std::min(kShakenRun, (count_ - 2) / 3);
      const int a = up_to(longest), b = up_to(longest),
                first = static_cast<int>(random() % static_cast<unsigned>(count_ - a - b));
      done_.clear();
      const double before = around(first) + around(first + a) + around(first + a + b);
      exchange(first, a, b);
      double change = around(first) + around(first + b) + around(first + a + b) - before;
      for (const int k : {first, first + b, first + a + b}) {
        if (k > 0) ask(exit(k - 1));
        if (k < count_) ask(entry_[k]);
      }
      change -= settle([] {});
      if (change > -kGain) {
        for (; !done_.empty(); done_.pop_back())
          turn_places(done_.back().first, done_.back().second);
      }
    }
  }

  const std::vector<int>& entries() const { return entry_; }

 private:
  void tell(double share) const {
    if (progress_) progress_(share);
  }
  int exit(int place) const { return entry_[place] ^ 1; }
  double distance(int a, int b) const { return (ends_.p[a] - ends_.p[b]).norm(); }
  // Length of the link from the previous stroke to the one at that place; the tour's ends cost
  // nothing.
  double around(int place) const {
    return place <= 0 || place >= count_ ? 0.0 : distance(exit(place - 1), entry_[place]);
  }
  double way(int from, int to) const { return from < 0 || to < 0 ? 0.0 : distance(from, to); }
  int exit_or_none(int place) const { return place < 0 ? -1 : exit(place); }
  int entry_or_none(int place) const { return place >= count_ ? -1 : entry_[place]; }

  void greedy() {
    struct Link {
      double length;
      int a, b;
    };
    std::vector<Link> links;
    for (int a = 0; a < 2 * count_; ++a) {
      for (const int b : near_[a]) {
        if (b >= 0) links.push_back({distance(a, b), a, b});
      }
    }
    std::sort(links.begin(), links.end(), [](const Link& x, const Link& y) {
      return std::tie(x.length, x.a, x.b) < std::tie(y.length, y.a, y.b);
    });
    // far: for a free end, the other free end of its chain
    std::vector<int> partner(2 * count_, -1), far(2 * count_);
    for (int e = 0; e < 2 * count_; ++e) far[e] = e ^ 1;
    for (const Link& link : links) {
      if (partner[link.a] >= 0 || partner[link.b] >= 0 || far[link.a] == link.b) continue;
      partner[link.a] = link.b;
      partner[link.b] = link.a;
      const int a = far[link.a], b = far[link.b];
      far[a] = b;
      far[b] = a;
    }
    // Appends the chains in turn, always the one with the nearest end.
    Ends loose;
    std::vector<int> free;
    for (int e = 0; e < 2 * count_; ++e) {
      if (partner[e] >= 0) continue;
      free.push_back(e);
      loose.p.push_back(ends_.p[e]);
    }
    NearestLeft left(loose);
    for (int at = 0; at >= 0;) {
      for (int e = free[at];;) {
        entry_.push_back(e);
        e = partner[e ^ 1];
        if (e < 0) break;
      }
      const int out = far[free[at]];
      left.remove(at);
      left.remove(static_cast<int>(std::lower_bound(free.begin(), free.end(), out) - free.begin()));
      at = left.nearest(ends_.p[out]);
    }
  }

  void ask(int end) {
    if (queued_[end]) return;
    queued_[end] = true;
    queue_.push_back(end);
  }

  // Improves the tour until no end in the queue has a gain left. Returns the total gain. `look` is
  // called before each look at an end.
  template <typename Look>
  double settle(Look&& look) {
    double gained = 0;
    while (!queue_.empty()) {
      look();
      const int end = queue_.front();
      queue_.pop_front();
      queued_[end] = false;
      for (double gain = better_at(end); gain > 0; gain = better_at(end)) gained += gain;
    }
    return gained;
  }

  // Makes one improving change that gives the end a nearer neighbour in the tour. Returns the gain,
  // 0 if there is none.
  double better_at(int end) {
    const bool is_exit = entry_[place_[end / 2]] != end;
    const int gap = place_[end / 2] + is_exit;  // between the places gap − 1 and gap
    const int before = exit_or_none(gap - 1), after = entry_or_none(gap);
    const double now = way(before, after);
    const bool free = before < 0 || after < 0;
    for (const int c : near_[end]) {
      if (c < 0) break;
      const double link = distance(end, c);
      if (!free && link >= now) break;
      const int k = place_[c / 2];
      const bool c_is_exit = entry_[k] != c;
      if (c_is_exit == is_exit) {
        const double gain = two_opt(gap, k + is_exit);
        if (gain > 0) return gain;
      }
      for (int length = 1; length <= kLongestMove; ++length) {
        // In the moved run, c is next to `end`.
        const int first = c_is_exit ? k - length + 1 : k;
        const double gain = move(first, length, gap, c_is_exit == is_exit);
        if (gain > 0) return gain;
      }
    }
    return 0;
  }

  // Reverses the strokes between two gaps.
  double two_opt(int gap_a, int gap_b) {
    const int i = std::min(gap_a, gap_b), j = std::max(gap_a, gap_b);
    if (i == j) return 0;
    const double gain = around(i) + around(j) - way(exit_or_none(i - 1), exit(j - 1)) -
                        way(entry_[i], entry_or_none(j));
    if (gain <= kGain) return 0;
    turn(i, j);
    ask_about({i, j});
    return gain;
  }

  // Moves `length` strokes from `first` into a gap, reversed or not.
  double move(int first, int length, int gap, bool turned) {
    const int last = first + length;
    if (first < 0 || last > count_ || (gap >= first && gap <= last)) return 0;
    const int in = turned ? exit(last - 1) : entry_[first],
              out = turned ? entry_[first] : exit(last - 1);
    const double gain = around(first) + around(last) + around(gap) -
                        way(exit_or_none(first - 1), entry_or_none(last)) -
                        way(exit_or_none(gap - 1), in) - way(out, entry_or_none(gap));
    if (gain <= kGain) return 0;
    if (gap < first) {
      turn(gap, last);
      turn(gap + length, last);
      if (!turned) turn(gap, gap + length);
      ask_about({gap, gap + length, last});
    } else {
      turn(first, gap);
      turn(first, gap - length);
      if (!turned) turn(gap - length, gap);
      ask_about({first, gap - length, gap});
    }
    return gain;
  }

  // Swaps the adjacent runs of a and b strokes from `first`.
  void exchange(int first, int a, int b) {
    turn(first, first + a + b);
    turn(first, first + b);
    turn(first + b, first + a + b);
  }

  void ask_about(std::initializer_list<int> gaps) {
    for (const int k : gaps) {
      if (k > 0) ask(exit(k - 1));
      if (k < count_) ask(entry_[k]);
    }
  }

  void turn(int i, int j) {
    turn_places(i, j);
    done_.emplace_back(i, j);
  }

  void turn_places(int i, int j) {
    std::reverse(entry_.begin() + i, entry_.begin() + j);
    for (int k = i; k < j; ++k) {
      entry_[k] ^= 1;
      place_[entry_[k] / 2] = k;
    }
  }

  std::function<void(double)> progress_;
  Ends ends_;
  std::vector<std::array<int, kNeighbours>> near_;
  int count_;
  std::vector<int> entry_, place_;
  std::deque<int> queue_;
  std::vector<char> queued_;
  std::vector<std::pair<int, int>> done_;  // reversals since the last shake
};

}  // namespace

std::vector<Visit> shortest_order(const std::vector<Stroke>& strokes, const OrderSettings& settings,
                                  const std::function<void(double)>& progress) {
  std::map<int, std::vector<int>> layers;
  for (std::size_t s = 0; s < strokes.size(); ++s)
    layers[settings.keep_layers ? strokes[s].layer : 0].push_back(static_cast<int>(s));
  std::vector<Visit> order;
  for (const auto& [layer, members] : layers) {
    Ends ends;
    for (const int s : members) {
      ends.p.push_back(strokes[s].points.front());
      ends.p.push_back(strokes[s].points.back());
    }
    const double before = static_cast<double>(order.size()) / static_cast<double>(strokes.size()),
                 own = static_cast<double>(members.size()) / static_cast<double>(strokes.size());
    Tour tour(std::move(ends), [&](double share) {
      if (progress) progress(before + own * share);
    });
    tour.improve();
    tour.shake(static_cast<int>(std::min<double>(
        kMostShakes, static_cast<double>(settings.shakes) * static_cast<double>(members.size()))));
    for (const int entry : tour.entries()) order.push_back({members[entry / 2], entry % 2 == 1});
  }
  return order;
}

void reverse(Stroke& stroke) {
  std::reverse(stroke.points.begin(), stroke.points.end());
  std::reverse(stroke.press.begin(), stroke.press.end());
}

std::vector<Stroke> in_order(const std::vector<Stroke>& strokes, const std::vector<Visit>& order) {
  std::vector<Stroke> ordered;
  ordered.reserve(order.size());
  for (const Visit& visit : order) {
    ordered.push_back(strokes.at(visit.stroke));
    if (visit.backwards) reverse(ordered.back());
  }
  return ordered;
}

double pen_up_length(const std::vector<Stroke>& strokes) {
  double length = 0;
  for (std::size_t i = 1; i < strokes.size(); ++i)
    length += (strokes[i].points.front() - strokes[i - 1].points.back()).norm();
  return length;
}

double pen_down_length(const std::vector<Stroke>& strokes) {
  double sum = 0;
  for (const Stroke& stroke : strokes) sum += length(stroke.points);
  return sum;
}

}  // namespace impedraw
