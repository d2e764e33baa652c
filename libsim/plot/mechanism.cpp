#include "libsim/plot/mechanism.hpp"

#include <algorithm>
#include <cmath>

namespace subsoil::sim {
namespace {

constexpr double kUnit = 5;  // pixels: radius of a pin, measure of all symbols
const Pen kInk{"#222222", 1.2}, kThin{"#555555", 0.8}, kShadow{"#b4b4b4", 1.2};

Spot turned(Spot a) { return {-a.y, a.x}; }
double length(Spot a) { return std::hypot(a.x, a.y); }

mbd::Vec2 world(const Poses& poses, int body, const Vec2& p) {
  const mbd::BodyState& pose = poses[static_cast<std::size_t>(body)];
  return pose.point_in_world(p);
}
double angle(const Poses& poses, int body) { return poses[static_cast<std::size_t>(body)].angle; }

/// One pose on a canvas.
class Painter {
 public:
  Painter(Canvas& canvas, const View& view, const Poses& poses) : canvas_(canvas), view_(view), poses_(poses) {}

  Spot at(int body, const Vec2& p) const { return view_(world(poses_, body, p)); }
  std::vector<Spot> spots(const Sketch::Outline& o) const {
    std::vector<Spot> out;
    for (const Vec2& p : o.points) out.push_back(at(o.body, p));
    return out;
  }

  void shape(const Sketch::Outline& o) {
    const std::string colour = MechanismDrawing::colour_of(o.body);
    if (o.closed && o.body != mbd::ground) canvas_.area(spots(o), colour, 0.72);
    canvas_.line(spots(o), {colour, o.closed ? 1.4 : 4.0}, o.closed);
  }
  void disk(const Sketch::Disk& d) {
    const Sketch::Outline rim{d.body, Sketch::circle(d.centre, d.radius)};
    shape(rim);
    const Vec2 on_rim{d.centre[0] + d.radius, d.centre[1]};
    canvas_.line({at(d.body, d.centre), at(d.body, on_rim)}, {MechanismDrawing::colour_of(d.body), 1});
  }
  void shadow(const Sketch::Outline& o) { canvas_.line(spots(o), {kShadow.colour, o.closed ? 1.2 : 3.0}, o.closed); }

  /// Cuts a line off at the edges of the view (Liang and Barsky); false when nothing is left.
  bool clip(Spot& from, Spot& to) const {
    const Spot low = view_.corner, high = low + view_.scale * Spot{view_.seen.width(), view_.seen.height()};
    const Spot d = to - from;
    double begin = 0, end = 1;
    const auto cut = [&](double step, double room) {  // step * share <= room
      if (step == 0) return room >= 0;
      (step > 0 ? end : begin) = step > 0 ? std::min(end, room / step) : std::max(begin, room / step);
      return begin < end;
    };
    if (!cut(d.x, high.x - from.x) || !cut(-d.x, from.x - low.x) || !cut(d.y, high.y - from.y) ||
        !cut(-d.y, from.y - low.y))
      return false;
    const Spot origin = from;
    from = origin + begin * d, to = origin + end * d;
    return true;
  }

  /// Short strokes on the right of a line, as of solid ground.
  void hatch(Spot from, Spot to) {
    if (!clip(from, to)) return;
    const double size = length(to - from);
    if (!(size > 0)) return;
    const Spot e = (1 / size) * (to - from), stroke = kUnit * (Spot{} - turned(e) - e);
    canvas_.line({from, to}, kInk);
    const int strokes = std::max(2, static_cast<int>(size / (1.6 * kUnit)));
    for (int i = 1; i <= strokes; ++i) {
      const Spot foot = from + (size * (i - 0.25) / strokes) * e;
      canvas_.line({foot, foot + stroke}, kThin);
    }
  }
  void pin(const Sketch::Pair& p) {
    const Spot spot = at(p.b, p.p_b);
    if (p.a == mbd::ground || p.b == mbd::ground) {
      const Spot left = spot + kUnit * Spot{-1.5, -2.4}, right = spot + kUnit * Spot{1.5, -2.4};
      canvas_.area({spot, left, right}, "#ffffff");
      canvas_.line({spot, left, right}, kInk, true);
      hatch(left - kUnit * Spot{0.9, 0}, right + kUnit * Spot{0.9, 0});
    }
    canvas_.disk(spot, 0.75 * kUnit, "#ffffff", kInk);
  }
  void weld(const Sketch::Pair& p) {
    const Spot spot = at(p.b, p.p_b);
    const double h = 0.7 * kUnit;
    canvas_.area({spot + Spot{-h, -h}, spot + Spot{h, -h}, spot + Spot{h, h}, spot + Spot{-h, h}}, kInk.colour);
    if (p.a == mbd::ground || p.b == mbd::ground)
      hatch(spot + kUnit * Spot{-2.4, -0.7}, spot + kUnit * Spot{2.4, -0.7});
  }

  /// Direction of a slide's line in the picture.
  Spot along(const Sketch::Slide& s) const {
    const double turn = angle(poses_, s.a) + s.angle_a;
    return {std::cos(turn), std::sin(turn)};
  }
  void guide(const Sketch::Slide& s, double from, double to) {
    Spot e = along(s);
    const Spot origin = at(s.a, s.p_a), beyond = 3.2 * kUnit * e;
    Spot tail = origin + view_.scale * from * e - beyond, head = origin + view_.scale * to * e + beyond;
    if (s.a != mbd::ground) {
      if (clip(tail, head)) canvas_.line({tail, head}, {MechanismDrawing::colour_of(s.a), 1.4});
      return;
    }
    if (e.x < 0 || (e.x == 0 && e.y > 0)) std::swap(tail, head), e = -1.0 * e;  // solid ground is below, or on the left
    const Spot below = -(s.block ? 1.3 * kUnit : view_.scale * s.below) * turned(e);
    hatch(tail + below, head + below);
  }
  void block(const Sketch::Slide& s) {
    const Spot spot = at(s.b, s.p_b), e = 2.1 * kUnit * along(s), n = 1.3 * kUnit * turned(along(s));
    if (s.slot) canvas_.disk(spot, 0.75 * kUnit, "#ffffff", kInk);
    if (!s.block) return;
    const std::vector<Spot> box{spot - e - n, spot + e - n, spot + e + n, spot - e + n};
    canvas_.area(box, "#ffffff");
    canvas_.area(box, MechanismDrawing::colour_of(s.b), 0.72);
    canvas_.line(box, {MechanismDrawing::colour_of(s.b), 1.4}, true);
  }

  void link(const Sketch::Link& l) {
    const Spot from = at(l.a, l.p_a), to = at(l.b, l.p_b);
    const double size = length(to - from);
    if (!(size > 0)) return;
    const Spot e = (1 / size) * (to - from), n = turned(e);
    const auto place = [&](double share, double aside) { return from + share * size * e + aside * kUnit * n; };
    if (l.kind == Sketch::Link::Kind::spring) {
      constexpr int turns = 6;
      std::vector<Spot> line{from, place(0.15, 0)};
      for (int i = 0; i < 2 * turns; ++i)
        line.push_back(place(0.15 + 0.7 * (i + 0.5) / (2 * turns), i % 2 ? -1.3 : 1.3));
      line.insert(line.end(), {place(0.85, 0), to});
      canvas_.line(line, kInk);
    } else if (l.kind == Sketch::Link::Kind::damper) {
      canvas_.line({from, place(0.35, 0)}, kInk);
      canvas_.line({place(0.65, 1.2), place(0.35, 1.2), place(0.35, -1.2), place(0.65, -1.2)}, kInk);
      canvas_.line({place(0.55, 1.0), place(0.55, -1.0)}, {kInk.colour, 2});
      canvas_.line({place(0.55, 0), to}, kInk);
    } else {
      canvas_.line({from, to}, {kInk.colour, 2});
    }
    for (const Spot end : {from, to}) canvas_.disk(end, 0.45 * kUnit, "#ffffff", kInk);
  }

  /// A straight side, as far as it is in the view.
  void side(const Sketch::Side& s) {
    const double turn = angle(poses_, s.body) + s.angle, far = 4 * (view_.seen.width() + view_.seen.height());
    const Spot at_point = at(s.body, s.point), reach = view_.scale * far * Spot{std::cos(turn), std::sin(turn)};
    Spot tail = at_point - reach, head = at_point + reach;
    if (!clip(tail, head)) return;
    if (s.body == mbd::ground)
      hatch(tail, head);
    else
      canvas_.line({tail, head}, {MechanismDrawing::colour_of(s.body), 1.4});
  }
  void marker(const mbd::Marker& m) { canvas_.disk(at(m.body, m.p), 0.4 * kUnit, kInk.colour, kInk); }

 private:
  Canvas& canvas_;
  const View& view_;
  const Poses& poses_;
};

}  // namespace

std::string MechanismDrawing::colour_of(int body) {
  // Okabe and Ito's: told apart by colour-blind readers. The ground is grey.
  static const char* const colours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8c6d31"};
  return body == mbd::ground ? "#555555" : colours[static_cast<std::size_t>(body - 1) % std::size(colours)];
}

MechanismDrawing::MechanismDrawing(const Sketch& sketch, const std::vector<Poses>& all) : sketch_(sketch) {
  reaches_.resize(sketch.slides.size());
  for (std::size_t i = 0; i < sketch.slides.size(); ++i)
    for (const Poses& poses : all) {
      const Sketch::Slide& s = sketch.slides[i];
      const double turn = angle(poses, s.a) + s.angle_a;
      const double slide = dot({std::cos(turn), std::sin(turn)}, world(poses, s.b, s.p_b) - world(poses, s.a, s.p_a));
      reaches_[i].from = std::min(reaches_[i].from, slide), reaches_[i].to = std::max(reaches_[i].to, slide);
    }
}

void MechanismDrawing::take_extent(const Poses& poses, Extent& extent) const {
  for (const auto& o : sketch_.outlines)
    for (const Vec2& p : o.points) extent.take(world(poses, o.body, p));
  for (const auto& d : sketch_.disks)
    for (const Vec2& p : Sketch::circle(d.centre, d.radius)) extent.take(world(poses, d.body, p));
  for (const auto* list : {&sketch_.pins, &sketch_.welds})
    for (const auto& p : *list) extent.take(world(poses, p.b, p.p_b));
  for (const auto& s : sketch_.slides) extent.take(world(poses, s.b, s.p_b));
  for (const auto& l : sketch_.links) extent.take(world(poses, l.a, l.p_a)), extent.take(world(poses, l.b, l.p_b));
  for (const auto& m : sketch_.markers) extent.take(world(poses, m.body, m.p));
}

void MechanismDrawing::draw(Canvas& canvas, const View& view, const Poses& poses) const {
  Painter paint(canvas, view, poses);
  for (const auto& s : sketch_.sides) paint.side(s);
  for (std::size_t i = 0; i < sketch_.slides.size(); ++i)
    paint.guide(sketch_.slides[i], reaches_[i].from, reaches_[i].to);
  for (const auto& d : sketch_.disks) paint.disk(d);
  for (const auto& o : sketch_.outlines) paint.shape(o);
  for (const auto& l : sketch_.links) paint.link(l);
  for (const auto& s : sketch_.slides) paint.block(s);
  for (const auto& m : sketch_.markers)
    if (m.body != mbd::ground) paint.marker(m);
  for (const auto& p : sketch_.welds) paint.weld(p);
  for (const auto& p : sketch_.pins) paint.pin(p);
}

void MechanismDrawing::draw_shadow(Canvas& canvas, const View& view, const Poses& poses) const {
  Painter paint(canvas, view, poses);
  for (const auto& d : sketch_.disks) paint.shadow({d.body, Sketch::circle(d.centre, d.radius)});
  for (const auto& o : sketch_.outlines) paint.shadow(o);
}

}  // namespace subsoil::sim
