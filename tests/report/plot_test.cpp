#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "report/plot/axis.hpp"
#include "report/plot/colours.hpp"
#include "report/plot/figure.hpp"
#include "report/plot/png.hpp"
#include "report/plot/thinning.hpp"
#include "report/run/run_data.hpp"
#include "text/number.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar::plot {
namespace {

std::vector<std::string> labels(const Ticks& ticks) {
  std::vector<std::string> out;
  for (const Tick& tick : ticks.ticks)
    if (!tick.label.empty()) out.push_back(tick.label);
  return out;
}

TEST(Ticks, AreRoundNumbersWithTheDigitsTheyNeed) {
  EXPECT_EQ(labels(ticks({"", -0.3, 1.1}, 6)),
            (std::vector<std::string>{"−0.2", "0.0", "0.2", "0.4", "0.6", "0.8", "1.0"}));
  EXPECT_EQ(labels(ticks({"", 0.0, 40.0}, 9)),
            (std::vector<std::string>{"0", "5", "10", "15", "20", "25", "30", "35", "40"}));
}

TEST(Ticks, OfAnyRangeAreAFewInsideIt) {
  for (double size = 1e-30; size < 1e30; size *= 1.7)
    for (const double low : {0.0, -size, 0.37 * size}) {
      const Axis axis{"", low, low + size};
      const Ticks marks = ticks(axis, 6);
      EXPECT_GE(marks.ticks.size(), 3u) << low << ' ' << size;
      EXPECT_LE(marks.ticks.size(), 13u) << low << ' ' << size;
      for (const Tick& tick : marks.ticks) {
        EXPECT_GE(axis.position(tick.value), -1e-9);
        EXPECT_LE(axis.position(tick.value), 1.0 + 1e-9);
      }
    }
}

TEST(Ticks, OfALowPictureAreTwoAtLeast) {
  for (double size = 1e-9; size < 1e9; size *= 1.13)
    for (const double low : {-size, -0.3 * size, 0.0, 0.77 * size})
      EXPECT_GE(ticks({"", low, low + 2.0 * size}, 2).ticks.size(), 2u) << low << ' ' << size;
}

TEST(Ticks, OfLargeNumbersShareAFactor) {
  const Ticks marks = ticks({"", 0.0, 2e6}, 4);
  EXPECT_EQ(marks.exponent, 6);
  EXPECT_EQ(labels(marks), (std::vector<std::string>{"0.0", "0.5", "1.0", "1.5", "2.0"}));
}

TEST(Ticks, OfALogarithmicAxisAreDecadesWithMinorOnesBetween) {
  const Axis axis = fitted_decades("", 3e-4, 0.2);
  EXPECT_EQ(axis.position(axis.low), 0.0);
  const Ticks marks = ticks(axis, 9);
  EXPECT_EQ(labels(marks), (std::vector<std::string>{"10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰"}));
  EXPECT_EQ(marks.ticks.size(), 5u + 4u * 8u);
  EXPECT_LE(labels(ticks(fitted_decades("", 1e-30, 1e30), 9)).size(), 10u);
}

// A mark at a whole decade is not cut in half by the frame.
TEST(Axis, OfDecadesHasRoomForMarksAtItsEnds) {
  Range range;
  range.add(1e-8);
  range.add(1e-2);
  const Axis axis = range.decades("");
  EXPECT_DOUBLE_EQ(axis.low, 1e-8 / 1.3);
  EXPECT_DOUBLE_EQ(axis.high, 1.3e-2);
  EXPECT_EQ(labels(ticks(axis, 9)).size(), 7u);
}

TEST(Axis, AConstantHasAnAxisAroundIt) {
  for (const double value : {0.0, 3.0, -1e-20}) {
    const Axis axis = fitted("", value, value);
    EXPECT_LT(axis.low, value);
    EXPECT_GT(axis.high, value);
  }
}

TEST(Axis, ASmallRangeFarFromZeroNeedsMoreDigits) {
  EXPECT_EQ((Axis{"u", -1.0, 1.0}.significant_digits(5)), 6);
  EXPECT_EQ((Axis{"u", 0.0, 1e-9}.significant_digits(5)), 6);
  // 10^-5 of 0.03 is 3e-7, the tenth digit of 650.
  EXPECT_EQ((Axis{"u", -650.02, -649.99}.significant_digits(5)), 10);
  EXPECT_EQ((Axis{"epsilon", 1e-14, 1.0, Scale::logarithmic}.significant_digits(5)), 6);
}

TEST(Readable, WritesForPeople) {
  EXPECT_EQ(readable(0.0), "0");
  EXPECT_EQ(readable(-1.5), "−1.5");
  EXPECT_EQ(readable(12345.0), "12345");
  EXPECT_EQ(readable(1e-6), "10⁻⁶");
  EXPECT_EQ(readable(2.5e7), "2.5\u202f×\u202f10⁷");
}

TEST(Rounding, BesideLargerNumbersIsZero) {
  EXPECT_EQ(above_rounding(-4.4e-106, 0.3), 0.0);
  EXPECT_EQ(above_rounding(4.16e-17, 1.0), 0.0);
  EXPECT_EQ(above_rounding(-1e-12, 1.0), -1e-12);
  EXPECT_EQ(above_rounding(4.16e-17, 1e-10), 4.16e-17);
}

TEST(Sentences, OfPagesHaveTheirSignsAndKeepKeys) {
  EXPECT_EQ(with_readable_numbers("1.50 +- 0.02 at epsilon = 1e-06"), "1.50 ± 0.02 at ε = 10⁻⁶");
  EXPECT_EQ(with_readable_numbers("three epsilons"), "three ε");
  for (const char* kept : {"contact.epsilon", "leave --epsilon out", "to_epsilon", "epsilon_of"})
    EXPECT_EQ(with_readable_numbers(kept), kept);
}

TEST(Ordinal, FollowsEnglish) {
  EXPECT_EQ(ordinal(2), "2nd");
  EXPECT_EQ(ordinal(11), "11th");
  EXPECT_EQ(ordinal(21), "21st");
  EXPECT_EQ(ordinal(64), "64th");
  EXPECT_EQ(ordinal(113), "113th");
}

TEST(ThinnedLine, KeepsAPeakOfASinglePointAmongAMillion) {
  ThinnedLine line(100);
  for (int i = 0; i < 1'000'000; ++i) line.add({static_cast<double>(i), i == 654'321 ? 5.0 : std::sin(0.01 * i)});
  const std::vector<Point> kept = line.points();
  EXPECT_LE(kept.size(), 400u);
  EXPECT_EQ(kept.front().x, 0.0);
  EXPECT_EQ(kept.back().x, 999'999.0);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end(), [](Point a, Point b) { return a.x < b.x; }));
  EXPECT_TRUE(std::any_of(kept.begin(), kept.end(), [](Point p) { return p.x == 654'321.0 && p.y == 5.0; }));
}

TEST(ThinnedLine, IsTheLineItselfWhileItIsShort) {
  const std::vector<Point> line = {{0, 1}, {1, -1}, {2, 4}, {3, 4}};
  ThinnedLine thinned(4);
  for (const Point& point : line) thinned.add(point);
  const std::vector<Point> kept = thinned.points();
  ASSERT_EQ(kept.size(), line.size());
  for (std::size_t i = 0; i < line.size(); ++i) EXPECT_EQ(kept[i].y, line[i].y);
}

// A page has a marker of some 200 bytes a point.
TEST(PointsOf, AreThoseThatBoundTheOthersWhereThereAreMany) {
  for (const std::size_t count : {most_points, 40 * most_points}) {
    std::vector<double> x(count), y(count, 0.0);
    std::iota(x.begin(), x.end(), 0.0);
    y[count / 3] = 1.0, y[count / 2] = std::numeric_limits<double>::quiet_NaN(), y[count - 7] = -2.0;
    const std::vector<Point> points = points_of(x, y);
    EXPECT_EQ(points.size() == count - 1, count == most_points);
    EXPECT_LE(points.size(), most_points);
    for (const std::size_t k : {std::size_t{0}, count / 3, count - 7, count - 1})
      EXPECT_TRUE(std::ranges::any_of(points, [&](const Point& p) { return p.x == x[k] && p.y == y[k]; })) << k;
    EXPECT_EQ(thinned_remark(count).empty(), count == most_points);
  }
}

TEST(ThinnedIntervals, StayFewAndCoverWhatTheyWereGiven) {
  ThinnedIntervals intervals;
  for (int i = 0; i < 100'000; ++i) intervals.add({i + 0.25, i + 0.75});
  EXPECT_LT(intervals.intervals().size(), 2000u);
  EXPECT_EQ(intervals.intervals().front().begin, 0.25);
  EXPECT_EQ(intervals.intervals().back().end, 99'999.75);
}

TEST(ThinnedField, KeepsEveryPowerOfTwothRowAndTheLast) {
  const Mesh mesh{1.0, 1003};
  ThinnedField field(mesh);
  std::vector<double> u(mesh.nodes());
  for (int k = 0; k < 5000; ++k) {
    u.assign(u.size(), k);
    u.back() = -k;
    field.add(0.5 * k, u);
  }
  EXPECT_EQ(field.time_stride(), 16u);
  EXPECT_EQ(field.node_stride(), 3u);
  EXPECT_EQ(field.x().back(), 1.0);
  EXPECT_LE(field.x().size(), 401u);
  ASSERT_LE(field.rows(), 401u);
  for (std::size_t row = 0; row + 1 < field.rows(); ++row) {
    EXPECT_EQ(field.time(row), 8.0 * static_cast<double>(row));
    EXPECT_EQ(field.row(row).front(), 16.0 * static_cast<double>(row));
  }
  EXPECT_EQ(field.time(field.rows() - 1), 0.5 * 4999);
  EXPECT_EQ(field.row(field.rows() - 1).back(), -4999.0);
}

// Relative luminance of sRGB.
double luminance(Colour colour) {
  const auto linear = [](unsigned byte) {
    const double c = byte / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(colour >> 16 & 0xff) + 0.7152 * linear(colour >> 8 & 0xff) + 0.0722 * linear(colour & 0xff);
}

TEST(ColourMap, TheSequentialOneGrowsLighterAllTheWay) {
  for (int i = 0; i < 64; ++i)
    EXPECT_LT(luminance(sequential().at(i / 64.0)), luminance(sequential().at((i + 1) / 64.0)));
}

TEST(ColourMap, TheDivergingOneIsLightestAtZeroAndAlikeOnBothSides) {
  for (int i = 0; i < 32; ++i) {
    const double inner = luminance(diverging().at(0.5 + i / 64.0)),
                 outer = luminance(diverging().at(0.5 + (i + 1) / 64.0));
    EXPECT_LT(outer, inner);
    EXPECT_LT(luminance(diverging().at(0.5 - (i + 1) / 64.0)), luminance(diverging().at(0.5 - i / 64.0)));
    EXPECT_NEAR(luminance(diverging().at(0.5 - i / 64.0)), inner, 0.1);
  }
}

TEST(Digits, AreThoseOfFmt) {
  for (const double value : {0.0, 0.1, 0.5, 2.0 / 3.0, 0.999999999, 1.0, 9.5, 123456.0, 1e16})
    for (const double factor : {1.0, -1.0, 1e-5, 1e-300, 1e280})
      for (const int precision : {1, 2, 5, 9, 17}) {
        std::string digits = "as ";
        append_digits(digits, value * factor, precision);
        EXPECT_EQ(digits, fmt::format("as {:.{}g}", value * factor, precision));
      }
}

// Half a thousandth, and rounding of the product and of what is read back.
TEST(Thousandths, AreNearestAndAsShortAsCanBe) {
  for (int k = -3000; k <= 3000; ++k)
    for (const double factor : {1.0, 1e-3, 0.3337, 12345.678901}) {
      const double value = k * factor;
      std::string text;
      append_thousandths(text, value);
      EXPECT_NEAR(std::stod(text), value, 0.5e-3 + 1e-15 * std::abs(value)) << text;
      EXPECT_TRUE(text.find('.') == text.npos || text.back() != '0') << text;
      EXPECT_NE(text, "-0");
    }
  std::string text = "M";
  for (const double value : {0.0, -0.0004, 84.0, 0.05, -2.125, 1e15}) append_thousandths(text, value), text += ' ';
  EXPECT_EQ(text, "M0 0 84 0.05 -2.125 1000000000000000 ");
}

TEST(Base64, OfTheVectorsOfRfc4648) {
  const std::string foobar = "foobar";
  const char* const encoded[] = {"", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
  for (std::size_t length = 0; length <= foobar.size(); ++length) {
    const std::vector<char> alone(foobar.begin(), foobar.begin() + length);  // nothing behind them to be read
    EXPECT_EQ(base64({alone.data(), alone.size()}), encoded[length]);
  }
  EXPECT_EQ(base64("\xff\xef\xbe"), "/+++");
}

std::string from_base64(std::string_view digits) {
  const std::string_view all = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::size_t bits = 0;
  for (std::size_t i = 0; i < digits.size() && digits[i] != '='; ++i) {
    bits = bits << 6 | all.find(digits[i]);
    if (i % 4 != 0) bytes += static_cast<char>(bits >> (6 - 2 * (i % 4)));
  }
  return bytes;
}

// Four bytes, the highest first.
std::size_t number_at(std::string_view bytes, std::size_t at) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < 4; ++i) number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

TEST(Png, IsReadByADecoder) {
  std::array<Colour, 256> palette{};
  for (Colour i = 0; i < 256; ++i) palette[i] = i << 16 | (255 - i) << 8 | 0x40;
  const std::string uri = png_data_uri(3, 2, palette, std::vector<std::uint8_t>{1, 2, 3, 4, 5, 255});
  // Head and end of the file and the checksums of the chunks in them, as an independent encoder wrote them.
  EXPECT_TRUE(uri.starts_with("data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAMAAAACCAMAAACqqpYoAAADAFBMVEUA/0AB"));
  const std::string png = from_base64(uri.substr(uri.find(',') + 1));
  EXPECT_TRUE(png.ends_with(std::string_view("\0\0\0\0IEND\xae\x42\x60\x82", 12)));
  const std::size_t chunk = png.find("IDAT"), length = png.size() - chunk - 4 - 4 - 12;
  const auto* const data = reinterpret_cast<const Bytef*>(png.data()) + chunk + 4;
  std::array<Bytef, 16> rows{};
  uLongf size = rows.size();
  ASSERT_EQ(uncompress(rows.data(), &size, data, length), Z_OK);
  // The first row as it is; the second less the row above it, modulo 256 (filter 2 of PNG).
  EXPECT_EQ(std::vector<int>(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(size)),
            (std::vector<int>{0, 1, 2, 3, 2, 3, 3, 252}));
  EXPECT_EQ(number_at(png, chunk - 4), length);
  EXPECT_EQ(number_at(png, chunk + 4 + length), crc32(0, data - 4, static_cast<uInt>(length + 4)));
}

TEST(Png, OfAFieldAtRestTakesAHundredthOfItsPixels) {
  const std::vector<std::uint8_t> pixels(400 * 300);
  const std::array<Colour, 256> palette{};
  const std::size_t head_palette_and_end = 8 + 25 + 780 + 12 + 12;
  EXPECT_LT(from_base64(png_data_uri(400, 300, palette, pixels).substr(22)).size() - head_palette_and_end,
            pixels.size() / 100);
}

TEST(Figure, EscapesTextsAndSurvivesPointsThatAreNotFinite) {
  Figure figure({"x", 0.0, 1.0}, {"a < b", 0.0, 1.0});
  figure.line(std::vector<Point>{{0, 0}, {0.5, std::nan("")}, {1, 1}}, {series_colour(0)}, "u & v");
  const std::string svg = figure.svg("title");
  EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
  EXPECT_NE(svg.find("u &amp; v"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(Figure, AsAFileHasItsColoursWithinAndNoVariables) {
  Figure figure({"x", 0.0, 1.0}, {"a < b", 0.0, 1.0});
  for (std::size_t i = 0; i < 6; ++i) figure.level(0.1 * static_cast<double>(i), {series_colour(i)}, "level");
  for (const double part : {0.0, 0.37, 1.0}) figure.markers(std::vector<Point>{{part, part}}, sequence_colour(part));
  const std::string file = figure.file("a & b");
  EXPECT_TRUE(
      file.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\""));
  EXPECT_NE(file.find("<title>a &amp; b</title>"), std::string::npos);
  EXPECT_NE(file.find("#0072b2"), std::string::npos);
  for (const char* of_a_page : {"var(", "currentColor", "data-theme"})
    EXPECT_EQ(file.find(of_a_page), std::string::npos);
}

// 13 pixels a letter at most 0.6 wide: beside the frame the widest tick and the name, which is 26 pixels from the edge.
TEST(Figure, LeavesRoomForWideTicksAndLongNames) {
  const Figure figure({"x", 0.0, 1.0}, {"a name that is longer than the frame is high", -650.02531, -650.02528}, 120.0);
  const std::string svg = figure.svg("title");
  std::size_t widest = 0;
  for (const Tick& tick : ticks({"", -650.02531, -650.02528}, 2).ticks)
    widest = std::max(widest, tick.label.size() - 2);
  const std::size_t frame = svg.find("<svg x=\"") + 8;
  EXPECT_GE(std::stod(svg.substr(frame)), 26.0 + 9.0 + 0.55 * 13.0 * static_cast<double>(widest));
  EXPECT_NE(svg.find("x=\"-60\" y=\"16\" text-anchor=\"middle\" style=\"font-size:"), std::string::npos);
}

TEST(Figure, WritesLongNamesOfTheLegendInLines) {
  Figure figure({"x", 0.0, 1.0}, {"y", 0.0, 1.0});
  figure.line(std::vector<Point>{{0, 0}, {1, 1}}, {series_colour(0)}, "siconos-bouncing-0.001");
  const std::string svg = figure.svg("title");
  EXPECT_NE(svg.find(">siconos-bouncing-</tspan>"), std::string::npos) << svg;
  EXPECT_NE(svg.find(">0.001</tspan>"), std::string::npos);
  EXPECT_NE(svg.find("data-key=\"siconos-bouncing-0.001\""), std::string::npos);
}

TEST(Palette, HasAColourForEachMethod) {
  std::set<std::string> colours;
  for (std::size_t i = 0; i < std::size(all_methods); ++i) colours.insert(in_light_colours(series_colour(i)));
  EXPECT_EQ(colours.size(), std::size(all_methods));
}

TEST(Figure, MarksForTheScriptOfAPageWhatItDraws) {
  Figure figure({.label = "t", .low = 0.0, .high = 1.0, .link = "t"}, fitted_decades("y", 0.1, 1.0));
  figure.series(std::vector<Point>{{0, 0.1}, {0.25, std::nan("")}, {1, 1.0}}, {series_colour(0), true, 2.0},
                "</script>");
  figure.shade(std::vector<Interval>{{0.25, 0.5}}, series_colour(1), "band");
  figure.level(0.5, {series_colour(0)});
  const std::string svg = figure.svg("a title");
  EXPECT_EQ(svg.find("</script>"), std::string::npos);
  const auto has = [&](const std::string& text) { return svg.find(text) != std::string::npos; };
  EXPECT_TRUE(has("aria-label=\"a title\""));
  EXPECT_TRUE(
      has("{&quot;label&quot;:&quot;t&quot;,&quot;low&quot;:0,&quot;high&quot;:1,&quot;link&quot;:&quot;t&quot;}"));
  EXPECT_TRUE(has("&quot;low&quot;:0.1,&quot;high&quot;:1,&quot;log&quot;:true}"));
  // From the lower left corner of the frame to the upper right one; the point without a value is left out.
  EXPECT_TRUE(has("class=\"line\" data-key=\"&lt;/script&gt;\" d=\"M84 214L800 12\""));
  EXPECT_TRUE(has("data-at=\"0 0.1\" data-key=\"&lt;/script&gt;\""));
  EXPECT_TRUE(has("data-at=\"1 1\" data-key=\"&lt;/script&gt;\""));
  // A level without a text is hidden with the line of its colour.
  EXPECT_TRUE(has("class=\"level\" data-level=\"0.5\" data-key=\"&lt;/script&gt;\""));
  EXPECT_TRUE(has("data-key=\"band\" d=\"M263 12.00h179v202H263z\""));
}

}  // namespace
}  // namespace viscobar::plot
