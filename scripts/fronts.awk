# Draws one panel for each trade.csv: relative RMSE in percent over a frame's time (logarithmic), front points joined, presets named.
# usage: awk -f scripts/fronts.awk NAME=TABLE.csv NAME=TABLE.csv ... >PICTURE.svg
BEGIN {
    FS = ","
    width = 320; height = 250; left = 44; right = 16; top = 28; bottom = 40
    for (i = 1; i < ARGC; i++) {
        split(ARGV[i], part, "=")
        read_table(part[1], part[2])
    }
    draw()
    exit
}
function read_table(name, path,    i, column, line, cells, n) {
    names[panels++] = name
    getline line <path
    n = split(line, cells)
    for (i = 1; i <= n; i++) column[cells[i]] = i
    least[name] = 1e30
    while ((getline line <path) > 0) {
        split(line, cells)
        n = count[name]++
        ms[name, n] = cells[column["frame_ms"]]
        rmse[name, n] = 100 * cells[column["relative_rmse"]]
        front[name, n] = cells[column["front"]]
        preset[name, n] = cells[column["preset"]]
        if (ms[name, n] < least[name]) least[name] = ms[name, n]
        if (ms[name, n] > most[name]) most[name] = ms[name, n]
        if (rmse[name, n] > highest[name]) highest[name] = rmse[name, n]
    }
    close(path)
}
function across(name, time) {
    return left + (width - left - right) * log(time / least[name]) / log(most[name] / least[name])
}
function up(name, percent) { return height - bottom - (height - top - bottom) * percent / limit[name] }
function tick_step(range) { return range > 40 ? 20 : range > 15 ? 5 : range > 6 ? 2 : 1 }
function panel(name, i,    n, k, tick, step, points, seen, best, right_half) {
    step = tick_step(highest[name])
    limit[name] = step * int(highest[name] / step + 1)
    printf "<g transform=\"translate(%d,0)\">\n<text x=\"%d\" y=\"16\" font-weight=\"bold\">%s</text>\n", i * width, left, name
    for (tick = 0; tick <= limit[name]; tick += step) {
        printf "<path d=\"M%d %.1fH%d\" stroke=\"#ddd\"/>\n", left, up(name, tick), width - right
        printf "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%d %%</text>\n", left - 5, up(name, tick) + 4, tick
    }
    for (tick = 1; tick <= 1e6; tick *= 10)
        for (k = 1; k <= 5; k = k == 1 ? 2 : k == 2 ? 5 : 6)
            if (k * tick >= least[name] && k * tick <= most[name])
                printf "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%d</text>\n", across(name, k * tick), height - bottom + 16, k * tick
    printf "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">ms a frame</text>\n", (left + width - right) / 2, height - 8
    for (n = 0; n < count[name]; n++)
        printf "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.4\" fill=\"%s\"/>\n", across(name, ms[name, n]), up(name, rmse[name, n]),
            front[name, n] ? "#1f4e9c" : "#bbb"
    do { # front points by time
        best = -1
        for (n = 0; n < count[name]; n++)
            if (front[name, n] && !(n in seen) && (best < 0 || ms[name, n] < ms[name, best])) best = n
        if (best >= 0) {
            seen[best] = 1
            points = points sprintf("%.1f,%.1f ", across(name, ms[name, best]), up(name, rmse[name, best]))
        }
    } while (best >= 0)
    printf "<polyline points=\"%s\" fill=\"none\" stroke=\"#1f4e9c\" stroke-width=\"1.4\"/>\n", points
    for (n = 0; n < count[name]; n++) {
        if (preset[name, n] == "") continue;
        right_half = across(name, ms[name, n]) > width / 2
        printf "<text x=\"%.1f\" y=\"%.1f\" fill=\"#c0392b\" text-anchor=\"%s\">%s</text>\n", across(name, ms[name, n]),
            up(name, rmse[name, n]) - 6, right_half ? "end" : "start", preset[name, n]
    }
    print "</g>"
}
function draw(    i) {
    printf "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" font-family=\"sans-serif\" font-size=\"11\">\n", panels * width, height
    print "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>"
    for (i = 0; i < panels; i++) panel(names[i], i)
    print "</svg>"
}
