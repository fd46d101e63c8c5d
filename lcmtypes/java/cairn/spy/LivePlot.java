package cairn.spy;

import info.monitorenter.gui.chart.Chart2D;
import info.monitorenter.gui.chart.IAxis;
import info.monitorenter.gui.chart.ITrace2D;
import info.monitorenter.gui.chart.rangepolicies.RangePolicyFixedViewport;
import info.monitorenter.gui.chart.rangepolicies.RangePolicyMinimumViewport;
import info.monitorenter.gui.chart.traces.Trace2DLtd;
import info.monitorenter.util.Range;
import java.awt.BorderLayout;
import java.awt.Color;
import java.awt.Font;
import java.util.HashMap;
import java.util.Map;
import javax.swing.BorderFactory;
import javax.swing.JLabel;
import javax.swing.JPanel;

/** One plot over the seconds since the launch, with a curve for each name. To be used on Swing's thread. */
class LivePlot extends JPanel {
  private static final int POINTS = 2400; // ten minutes of the learner's four a second
  private static final int NAMES = 12; // more would leave no room for the curves
  private static final Color[] COLORS = {
    new Color(0x1f77b4), new Color(0xd62728), new Color(0x2ca02c), new Color(0xff7f0e),
    new Color(0x9467bd), new Color(0x8c564b), new Color(0xe377c2), new Color(0x17becf),
  };

  private final Chart2D chart = new Chart2D();
  private final Map<String, ITrace2D> curves = new HashMap<>();
  private final JLabel head = new JLabel();
  private final String title;

  /** With a fixed range of values, or from 0 up as they come where `top` is 0. */
  LivePlot(String title, double top) {
    super(new BorderLayout());
    this.title = title;
    head.setText(title);
    head.setFont(head.getFont().deriveFont(Font.BOLD));
    head.setBorder(BorderFactory.createEmptyBorder(4, 8, 0, 8));
    IAxis<?> values = chart.getAxisY();
    values.setRangePolicy(
        top > 0
            ? new RangePolicyFixedViewport(new Range(0, 1.1 * top)) // not on the edge
            : new RangePolicyMinimumViewport(new Range(0, 1)));
    values.getAxisTitle().setTitle("");
    values.setPaintGrid(true);
    chart.getAxisX().getAxisTitle().setTitle("s");
    chart.setGridColor(new Color(0xe0e0e0));
    chart.setUseAntialiasing(true);
    add(head, BorderLayout.NORTH);
    add(chart, BorderLayout.CENTER);
  }

  void add(String name, double seconds, double value) {
    ITrace2D curve = curves.get(name);
    if (curve == null) {
      curve = new Trace2DLtd(POINTS, name);
      curve.setColor(COLORS[curves.size() % COLORS.length]);
      curves.put(name, curve);
      chart.addTrace(curve);
      chart.setPaintLabels(curves.size() <= NAMES);
    }
    curve.addPoint(seconds, value);
  }

  /** The newest value in words, behind the title. */
  void say(String words) {
    head.setText(title + ": " + words);
  }
}
