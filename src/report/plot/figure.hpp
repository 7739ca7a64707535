#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "report/plot/axis.hpp"
#include "report/plot/colours.hpp"
#include "report/plot/thinning.hpp"

namespace viscobar::plot {

/// How a series is drawn. `colour` is any CSS colour, such as series_colour(i), which follows light and dark.
struct Style {
  std::string colour;
  bool dashed = false;
  double width = 1.6;
  std::size_t shape = 0;  ///< tells series apart without colour: dashes of a line, outline of a marker; 0: plain, round
};

/// SVG of the alternatives for Style::shape: dashes of a line ("" for none), and markers around the origin, as paths.
std::span<const std::string_view> dash_shapes();
std::span<const std::string_view> marker_shapes();

/// Height of a figure of bars() on a bare y axis from rows - 1/2 down to -1/2: each bar stands beside its legend.
double height_of_bars(std::size_t rows);

/// A picture with two axes, as SVG. Curves added first lie below. The legend stands right of the frame, whose place is
/// the same in every figure of one width, so that figures below each other share their axis.
///
/// On a page a script zooms it (src/report/web/chart.js), by these marks in it: `data-x` and `data-y` hold the axes;
/// the frame is an SVG of its own, a view into what is drawn; `data-key` names the line of the legend with which an
/// element is hidden; a .fixed element keeps its size; markers tell their point in `data-at`, levels their height in
/// `data-level`.
class Figure {
 public:
  Figure(Axis x, Axis y, double height = 260.0);

  void shade(std::span<const Interval> bands, const std::string& colour, std::string_view legend = {});
  void level(double y, const Style& style, std::string_view legend = {});
  /// A solid body below y over the part of x, or above it.
  void body(double y, Interval part, bool above = false);
  /// The area between two lines over the same x, the upper one lifted by some pixels.
  void area(std::span<const Point> lower, std::span<const Point> upper, double lift);
  void line(std::span<const Point> points, const Style& style, std::string_view legend = {});
  void markers(std::span<const Point> points, const std::string& colour, std::string_view legend = {},
               std::size_t shape = 0);
  void series(std::span<const Point> points, const Style& style, std::string_view legend = {});
  void label(Point at, std::string_view text);
  /// A vertical line through the frame, the text, if any, at its top.
  void marker_line(double x, const Style& style, std::string_view text);
  /// Horizontal bars of one height in y, a line of the legend as high as they are.
  void bars(std::span<const Interval> parts, double y, const std::string& colour, std::string_view legend);
  /// A body along x at the height y, in colours that change along it.
  struct ColourStop {
    double at;
    Colour colour;
  };
  void strip(double from, double to, double y, std::span<const ColourStop> stops);
  /// A rigid one, as thick as a strip.
  void block(double from, double to, double y);
  /// A mark of a joint at the height y, which stands out above and below a strip.
  void joint(double at, double y);
  /// A line of the legend at the height y.
  void words_beside(double y, std::string_view words);
  /// Upright walls over the whole height, or over a part of y, hatched to the right or to the left; `open` ones leave
  /// the middle free.
  struct Wall {
    double at;
    bool to_the_right, open;
    std::optional<Interval> part{};
  };
  void walls(std::span<const Wall> walls);
  /// An image over the rectangle between two corners of the frame's coordinates.
  void image(const std::string& uri, Point low, Point high);
  /// A colour bar in place of a legend; `symbol` is what its values are called.
  void colour_bar(const ColourMap& map, const Axis& values, std::string_view symbol);
  /// A line of the legend that stands for nothing drawn by line().
  void legend_box(const std::string& colour, std::string_view text);
  void legend_note(std::string_view text);

  /// From here on, until that is over, for readers without the page's script, which draws the same in motion.
  void begin_still();
  void end_still();
  void set_live_height(double height) { live_height_ = height; }

  /// Inline SVG, whose colours are variables of the page. @param title read out in place of the picture
  std::string svg(std::string_view title) const;
  /// An SVG file of its own, in light colours, with its fonts named.
  std::string file(std::string_view title) const;

 private:
  double place_x(double value) const;
  double place_y(double value) const;
  /// An SVG path through points; absent where none is finite.
  std::string path(std::span<const Point> points) const;
  std::string boxes(std::span<const Interval> parts, double top, double height) const;
  /// The attribute that names the line of the legend: a line without a text belongs to the last one of its colour.
  std::string key(const std::string& colour, std::string_view legend);
  void stroke(std::span<const Point> points, const Style& style, std::string_view attributes);
  void legend_line(const Style& style, std::string_view text);
  void legend_key(std::string_view mark, std::string_view text, std::string_view key, double indent = 27.0,
                  bool one_line = false);
  std::string gradient(std::span<const ColourStop> stops, std::string_view direction);

  Ticks ticks_up() const;

  Axis x_, y_;
  double height_, left_;
  std::optional<double> live_height_;
  std::string content_, legend_;
  std::map<std::string, std::string> keys_;  // of the last line of the legend in a colour
  double legend_y_;
  std::size_t gradients_ = 0;
};

std::string_view drawing_css();

}  // namespace viscobar::plot
