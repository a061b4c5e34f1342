from pathlib import Path
import numpy as np
from dolfingrip.config import Config
from dolfingrip.diagnosis.data import measurement as m
from dolfingrip.diagnosis.coupon.compare import compared
from dolfingrip.diagnosis import selection
me,notes=selection.selected(m.read([Path('examples/coupons/ecoflex30_uniaxial.csv')],Config()),Config())
print(notes, len(me.listed()), me.listed().control.max())
f=compared(me,Config(),say=print)
print(f.decision.answer,f.decision.first,f.decision.second,f.decision.probability,f.left_by_emulator, f.decision.unexplained)
for p,fit in sorted(zip(f.posterior.probability,f.posterior.fits),key=lambda e:-e[0])[:12]:
    ex=f.analysed.exact(fit); print(round(p,4),fit.subset,fit.level,round(fit.log_evidence,2),fit.zeta.round(2),fit.draws is not None, np.isnan(ex).sum(), f.analysed.factor(fit))
