# Draws one panel for each knob of a table knob,value,frames,relative_rmse,flip_ldr,...: error over the knob's values, in their order.
# usage: awk -f scripts/curves.awk TABLE.csv >PICTURE.svg
# Left axis and solid lines: relative RMSE in percent; dashed: FLIP times 100, on the same axis.
BEGIN {
    FS = ","
    width = 260; height = 190; columns = 3; left = 40; right = 12; top = 28; bottom = 30
}
FNR > 1 && $1 != "variant" {
    if (!($1 in count)) names[panels++] = $1
    n = count[$1]++
    value[$1, n] = $2
    rmse[$1, n] = 100 * $4
    flip[$1, n] = 100 * $5
    if (rmse[$1, n] > highest) highest = rmse[$1, n]
    if (flip[$1, n] > highest) highest = flip[$1, n]
}
function across(name, n) { return left + (width - left - right) * (count[name] > 1 ? n / (count[name] - 1) : 0.5) }
function up(percent) { return height - bottom - (height - top - bottom) * percent / limit }
function curve(name, percent, style,    n, points) {
    for (n = 0; n < count[name]; n++)
        points = points sprintf("%.1f,%.1f ", across(name, n), up(percent[name, n]))
    printf "<polyline points=\"%s\" fill=\"none\" stroke-width=\"1.6\" %s/>\n", points, style
    for (n = 0; n < count[name]; n++)
        printf "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.4\" %s/>\n", across(name, n), up(percent[name, n]), style
}
function panel(name, i,    n, tick) {
    printf "<g transform=\"translate(%d,%d)\">\n", i % columns * width, int(i / columns) * height
    printf "<text x=\"%d\" y=\"16\" font-weight=\"bold\">%s</text>\n", left, name
    for (tick = 0; tick <= limit; tick += 20) {
        printf "<path d=\"M%d %.1fH%d\" stroke=\"#ddd\"/>\n", left, up(tick), width - right
        printf "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%d</text>\n", left - 5, up(tick) + 4, tick
    }
    for (n = 0; n < count[name]; n++)
        printf "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%s</text>\n", across(name, n), height - bottom + 16, value[name, n]
    curve(name, rmse, "stroke=\"#1f4e9c\"")
    curve(name, flip, "stroke=\"#c0392b\" stroke-dasharray=\"5 3\"")
    print "</g>"
}
END {
    limit = 20 * int(highest / 20 + 0.999)
    rows = int((panels + columns - 1) / columns)
    printf "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" font-family=\"sans-serif\" font-size=\"11\">\n", columns * width, rows * height + 20
    print "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>"
    for (i = 0; i < panels; i++) panel(names[i], i)
    printf "<text x=\"%d\" y=\"%d\"><tspan fill=\"#1f4e9c\">solid: relative RMSE, percent</tspan> <tspan fill=\"#c0392b\">dashed: FLIP x 100</tspan></text>\n", left, rows * height + 12
    print "</svg>"
}
