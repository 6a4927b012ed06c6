// the parts of ECharts that bearingsim/report/assets/report.js draws with
import { CustomChart, LineChart, ScatterChart } from 'echarts/charts';
import {
  AriaComponent, DataZoomInsideComponent, DataZoomSliderComponent, GridComponent, LegendComponent, TooltipComponent,
} from 'echarts/components';
import * as core from 'echarts/core';
import { SVGRenderer } from 'echarts/renderers';

core.use([
  AriaComponent, CustomChart, DataZoomInsideComponent, DataZoomSliderComponent, GridComponent, LegendComponent,
  LineChart, ScatterChart, SVGRenderer, TooltipComponent,
]);

export const init = core.init;
